//! The faults of the campaign, each with its injection and the required reaction.

use palpate::Fault;
use palpate::haptic::cycle::Ask;

use super::{Expected, FaultType, ForceFault, Host, Injection, Needs, Opening, Reading, TissueFault};

const FOR_EVER: u32 = u32::MAX;
const SENSOR: &[Fault] = &[Fault::SensorFault];
const NAN_POSE: &[Fault] = &[Fault::PoseNotFinite];
const STALE: &[Fault] = &[Fault::PoseStale];
const FAST: &[Fault] = &[Fault::OverSpeed];
const FAR: &[Fault] = &[Fault::OverSpeed, Fault::OutOfWorkspace];
const LATE: &[Fault] = &[Fault::DeadlineMissed];
const NAN_FORCE: &[Fault] = &[Fault::ForceNotFinite];
/// Faults that end a force far above the limit: `ForceImplausible` after ten ticks, or `TipApart`
/// if that force has pushed the probe out earlier and the renderer still returns it for five ticks
/// outside, where none of it is applied.
const LONG_FORCE: &[Fault] = &[Fault::ForceImplausible, Fault::TipApart];
const NODE: &[Fault] = &[Fault::Diverged, Fault::ForceNotFinite];
const AWAY: &[Fault] = &[Fault::Runaway];
/// Faults in which a handle that the force drives into the tissue may end. A light handle may
/// exceed the speed limit before it has moved far enough for a runaway.
const AWAY_FAST: &[Fault] = &[Fault::Runaway, Fault::OverSpeed];
/// Faults in which a wrong sign or a stuck reading may end, where it can be detected.
const WRONG_WAY: &[Fault] =
    &[Fault::Runaway, Fault::OverSpeed, Fault::SensorFault, Fault::OutOfWorkspace, Fault::EnergyCreated, Fault::TipApart];

/// Faults in which noise of many counts may end.
const NOISY: &[Fault] = &[Fault::OverSpeed, Fault::SensorFault, Fault::OutOfWorkspace, Fault::EnergyCreated, Fault::TipApart];

const fn with(
    id: &'static str,
    name: &'static str,
    injection: Injection,
    ticks: u32,
    needs: Needs,
    expected: Expected,
) -> FaultType {
    FaultType { id, name, opening: Opening::Active, injection, ticks, needs, expected }
}

const fn reading(
    id: &'static str,
    name: &'static str,
    fault: Reading,
    ticks: u32,
    needs: Needs,
    expected: Expected,
) -> FaultType {
    with(id, name, Injection::Reading(fault), ticks, needs, expected)
}

const fn drive(id: &'static str, name: &'static str, fault: ForceFault, ticks: u32, expected: Expected) -> FaultType {
    with(id, name, Injection::ForceFault(fault), ticks, Needs::Force, expected)
}

const fn host(id: &'static str, name: &'static str, fault: Host, expected: Expected) -> FaultType {
    with(id, name, Injection::Host(fault), FOR_EVER, Needs::Nothing, expected)
}

const fn tissue(id: &'static str, name: &'static str, fault: TissueFault, ticks: u32, expected: Expected) -> FaultType {
    with(id, name, Injection::Tissue(fault), ticks, Needs::Force, expected)
}

const fn late(id: &'static str, name: &'static str, ticks: u16, every: u32, lasting: u32, expected: Expected) -> FaultType {
    with(id, name, Injection::Late { ticks, every }, lasting, Needs::Nothing, expected)
}

const fn opening(id: &'static str, name: &'static str, opening: Opening, expected: Expected) -> FaultType {
    FaultType { id, name, opening, injection: Injection::None, ticks: 0, needs: Needs::Nothing, expected }
}

const fn shifted(out_m: f32, aside_m: f32) -> Reading {
    Reading::Shifted { out_m, aside_m }
}

/// Every kind of fault that the campaign injects.
pub const FAULTS: &[FaultType] = &[
    with("F0", "nothing wrong", Injection::None, 0, Needs::Nothing, Expected::Ridden),
    // readings
    reading("P1-nan", "pose is NaN", Reading::Is(f32::NAN), FOR_EVER, Needs::Nothing, Expected::Fault(NAN_POSE, 1)),
    reading("P1-inf", "pose is infinite", Reading::Is(f32::INFINITY), FOR_EVER, Needs::Nothing, Expected::Fault(NAN_POSE, 1)),
    reading("P1-once", "pose is NaN for a tick", Reading::Is(f32::NAN), 1, Needs::Nothing, Expected::Fault(NAN_POSE, 1)),
    reading("P2", "out of the workspace", shifted(0.25, 0.0), FOR_EVER, Needs::Nothing, Expected::Fault(FAR, 2)),
    reading("P2-far", "out by 1e30 m", Reading::Is(1e30), FOR_EVER, Needs::Nothing, Expected::Fault(FAR, 2)),
    reading("P3-1mm", "jump of 1 mm, one tick", shifted(0.0, 1e-3), 1, Needs::Nothing, Expected::Ridden),
    reading("P3-5mm", "jump of 5 mm, one tick", shifted(0.0, 5e-3), 1, Needs::Nothing, Expected::Ridden),
    reading("P3-50mm", "jump of 50 mm, one tick", shifted(0.0, 50e-3), 1, Needs::Nothing, Expected::Ridden),
    reading("P3-in", "jump of 5 mm inwards, one tick", shifted(-5e-3, 0.0), 1, Needs::Nothing, Expected::Ridden),
    reading("P4", "encoder stuck at speed", Reading::Stuck, FOR_EVER, Needs::FastForce, Expected::Fault(SENSOR, 4)),
    reading("P4-slow", "encoder stuck, any time", Reading::Stuck, FOR_EVER, Needs::Nothing, Expected::Bounded(WRONG_WAY)),
    reading("P4-back", "encoder stuck for 100 ms", Reading::Stuck, 100, Needs::Nothing, Expected::Bounded(WRONG_WAY)),
    reading("P5", "every sign of the encoder wrong", Reading::Mirrored, FOR_EVER, Needs::Force, Expected::Bounded(WRONG_WAY)),
    reading(
        "P5-axis",
        "one sign of the encoder wrong",
        Reading::MirroredAxis,
        FOR_EVER,
        Needs::Force,
        Expected::Bounded(WRONG_WAY),
    ),
    reading("P6", "index lost, says so", Reading::Failed, FOR_EVER, Needs::Nothing, Expected::Fault(SENSOR, 1)),
    reading("P6-jump", "index lost: 10 mm off for good", shifted(10e-3, 0.0), FOR_EVER, Needs::Force, Expected::Fault(FAST, 2)),
    reading("P7", "one count of dither", Reading::Noise(1), FOR_EVER, Needs::Nothing, Expected::Ridden),
    reading("P8", "numbers of readings wrap", Reading::Wraps, FOR_EVER, Needs::Nothing, Expected::Ridden),
    reading("P9-1", "one reading repeated", Reading::Repeated, 1, Needs::Nothing, Expected::Ridden),
    reading("P9-2", "two readings repeated", Reading::Repeated, 2, Needs::Nothing, Expected::Ridden),
    reading("P9-10", "ten readings repeated", Reading::Repeated, 10, Needs::Nothing, Expected::Fault(STALE, 3)),
    reading("P9-100", "no reading for 100 ms", Reading::Repeated, 100, Needs::Nothing, Expected::Fault(STALE, 3)),
    reading("P10", "numbers go back by 50", Reading::Behind(50), 40, Needs::Nothing, Expected::Fault(STALE, 3)),
    reading("P10-once", "one reading out of order", Reading::Behind(2), 1, Needs::Nothing, Expected::Ridden),
    reading("P11", "readings two ticks late", Reading::Late(2), FOR_EVER, Needs::Nothing, Expected::Bounded(WRONG_WAY)),
    reading("P11-jitter", "readings jitter by a tick", Reading::Jitter, FOR_EVER, Needs::Nothing, Expected::Bounded(WRONG_WAY)),
    reading("P12", "one axis frozen at speed", Reading::Frozen, FOR_EVER, Needs::FastForce, Expected::Fault(SENSOR, 4)),
    reading("P12-slow", "one axis frozen, any time", Reading::Frozen, FOR_EVER, Needs::Nothing, Expected::Bounded(WRONG_WAY)),
    reading("P13", "noise of ten counts", Reading::Noise(10), FOR_EVER, Needs::Nothing, Expected::Bounded(NOISY)),
    // forces
    drive("A1", "actuators end at 0.5 N", ForceFault::Saturated(0.5), FOR_EVER, Expected::Ridden),
    drive("A2", "actuators stuck at their force", ForceFault::Stuck, FOR_EVER, Expected::Bounded(WRONG_WAY)),
    drive("A2-drop", "forces lost for 20 ticks", ForceFault::Dropped, 20, Expected::Bounded(AWAY)),
    drive("A3", "force of the wrong sign", ForceFault::Scaled(-1.0), FOR_EVER, Expected::Bounded(WRONG_WAY)),
    with(
        "A3-free",
        "wrong sign, unheld",
        Injection::ForceFault(ForceFault::Scaled(-1.0)),
        FOR_EVER,
        Needs::NobodysForce,
        // the handle may pass through the tissue, and then have no force, before it is too fast
        Expected::Bounded(AWAY_FAST),
    ),
    with(
        "A3-weak",
        "wrong sign, a third, unheld",
        Injection::ForceFault(ForceFault::Scaled(-0.33)),
        FOR_EVER,
        Needs::NobodysForce,
        // the handle may have passed through the tissue, and have no force, before a runaway is
        // certain
        Expected::Bounded(AWAY),
    ),
    drive("A7-1ms", "amplifier lag of 1 ms", ForceFault::Lag(1e-3), FOR_EVER, Expected::Ridden),
    drive("A7-5ms", "amplifier lag of 5 ms", ForceFault::Lag(5e-3), FOR_EVER, Expected::Bounded(WRONG_WAY)),
    drive("A7-late", "forces two ticks later", ForceFault::Late(2), FOR_EVER, Expected::Bounded(WRONG_WAY)),
    drive("A8-none", "no friction", ForceFault::Friction(0.0), FOR_EVER, Expected::Ridden),
    drive("A8-high", "ten times the friction", ForceFault::Friction(10.0), FOR_EVER, Expected::Ridden),
    with("A5", "supply low", Injection::Found(Fault::SupplyLow), 1, Needs::Nothing, Expected::Fault(&[Fault::SupplyLow], 1)),
    with(
        "A4",
        "self-test fails under way",
        Injection::Found(Fault::SelfTestFailed),
        1,
        Needs::Nothing,
        Expected::Fault(&[Fault::SelfTestFailed], 1),
    ),
    // host
    host("C6", "host silent", Host::Silent, Expected::Ramp(20)),
    with("C6-short", "host silent for 15 ms", Injection::Host(Host::Silent), 15, Needs::Nothing, Expected::Ridden),
    host("C6-stop", "host says stop", Host::Asks(Ask::Stop), Expected::Ramp(1)),
    host("C8", "host asks to arm in contact", Host::Asks(Ask::Arm), Expected::Ridden),
    host("C11", "host clears a fault that is not there", Host::Asks(Ask::Clear), Expected::Ridden),
    host("C11-boot", "host says booted again", Host::Asks(Ask::Booted), Expected::Ridden),
    host("C9-low", "longest force halved in place", Host::Lowers, Expected::Ridden),
    host("C9-high", "force limit raised", Host::Raises(0), Expected::Ridden),
    host("C9-nan", "force limit not a number", Host::Raises(1), Expected::Ridden),
    host("C9-slew", "slew limit raised", Host::Raises(2), Expected::Ridden),
    host("C9-speed", "speed limit negative", Host::Raises(3), Expected::Ridden),
    // timing
    late("T1", "one tick late by one", 1, FOR_EVER, 1, Expected::Ridden),
    late("T1-2", "one tick late by two", 2, FOR_EVER, 1, Expected::Fault(LATE, 1)),
    late("T1-20", "one tick late by twenty", 20, FOR_EVER, 1, Expected::Fault(LATE, 1)),
    late("T3", "every tick late", 1, 1, FOR_EVER, Expected::Fault(LATE, 2)),
    late("T3-half", "every second tick late", 1, 2, FOR_EVER, Expected::Fault(LATE, 9)),
    late("T3-rare", "every fiftieth tick late", 1, 50, FOR_EVER, Expected::Fault(LATE, 201)),
    late("T3-four", "four late ticks in 200", 1, 50, 160, Expected::Ridden),
    // model and numbers
    tissue("N1", "a node at NaN", TissueFault::NodeAt(f32::NAN), 1, Expected::Fault(NODE, 2)),
    tissue("N1-far", "a node at 1e30 m", TissueFault::NodeAt(1e30), 1, Expected::Fault(NODE, 2)),
    tissue("N2", "a node of infinite speed", TissueFault::NodeSpeed(f32::INFINITY), 1, Expected::Fault(NODE, 2)),
    tissue("N2-nan", "a node whose speed is NaN", TissueFault::NodeSpeed(f32::NAN), 1, Expected::Fault(NODE, 2)),
    tissue("N3", "force 1e30 N", TissueFault::Force(1e30), FOR_EVER, Expected::Fault(NAN_FORCE, 1)),
    tissue("N3-nan", "force NaN", TissueFault::Aside(f32::NAN), FOR_EVER, Expected::Fault(NAN_FORCE, 1)),
    tissue("N3-inf", "force infinite", TissueFault::Force(f32::INFINITY), 1, Expected::Fault(NAN_FORCE, 1)),
    tissue("N3-20", "force 20 N", TissueFault::Force(20.0), FOR_EVER, Expected::Fault(LONG_FORCE, 16)),
    tissue("N3-short", "force 20 N for 9 ticks", TissueFault::Force(20.0), 9, Expected::Bounded(WRONG_WAY)),
    tissue("N3-12", "force 12 N, on and on", TissueFault::Force(12.0), FOR_EVER, Expected::Degraded(208)), // a probe that is pushed out takes five ticks more
    tissue("N4", "every speed denormal", TissueFault::Denormal(1e-41), 1, Expected::Ridden),
    tissue("N5", "force turned aside by 2 N", TissueFault::Aside(2.0), FOR_EVER, Expected::Bounded(WRONG_WAY)),
    tissue("C9-x3", "tissue three times as stiff in contact", TissueFault::Scaled(3.0), FOR_EVER, Expected::Bounded(WRONG_WAY)),
    tissue("C9-half", "tissue half as stiff in contact", TissueFault::Scaled(0.5), FOR_EVER, Expected::Ridden),
    tissue(
        "N6",
        "tissue that makes energy",
        TissueFault::Active(2.0),
        FOR_EVER,
        Expected::Bounded(&[Fault::EnergyCreated, Fault::OverSpeed]),
    ),
    // start
    opening("B1", "power on in the tissue", Opening::Inside, Expected::Nothing),
    opening("B3", "waved about at arming", Opening::Waving, Expected::Nothing),
    opening("B3-touch", "touched while the gain ramps in", Opening::RampingIn, Expected::Ridden),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_unique_and_forty_types_at_least_inject_something() {
        assert!(FAULTS.iter().filter(|f| f.injection != Injection::None).count() >= 40);
        for (n, fault) in FAULTS.iter().enumerate() {
            assert!(FAULTS[..n].iter().all(|f| f.id != fault.id && f.name != fault.name), "{}", fault.id);
        }
    }
}
