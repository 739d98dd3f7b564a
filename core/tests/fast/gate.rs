//! The pose gate: readings that are accepted, held or refused.

use palpate::haptic::device::{Sensed, SensorStatus};
use palpate::haptic::limits::{LoopLimitSettings, LoopLimits, Pose, PoseGate};
use palpate::{Fault, Vector3};

use crate::bench::{TICK_S, limits, stylus};

/// A gate that is given one reading after the other.
struct Gate {
    gate: PoseGate,
    limits: LoopLimits,
    sequence: u32,
    at_m: Vector3<f32>,
    force_acts: bool,
}

impl Gate {
    fn new() -> Self {
        Self { gate: PoseGate::default(), limits: limits(), sequence: 0, at_m: Vector3::zeros(), force_acts: true }
    }

    /// A gate that has accepted the origin.
    fn believing() -> Self {
        let mut gate = Self::new();
        gate.read(Vector3::zeros()).unwrap();
        gate
    }

    /// Passes a new reading at this position [m].
    fn read(&mut self, at_m: Vector3<f32>) -> Result<Pose, Fault> {
        self.sequence = self.sequence.wrapping_add(1);
        self.at_m = at_m;
        self.repeat()
    }

    /// Passes the last reading once more.
    fn repeat(&mut self) -> Result<Pose, Fault> {
        let sensed = Sensed { position_m: self.at_m, sequence: self.sequence, status: SensorStatus::Good };
        self.gate.admit(&self.limits, &sensed, self.force_acts)
    }

    /// Passes a new reading this much further along an axis [m].
    fn step(&mut self, axis: usize, step_m: f32) -> Result<Pose, Fault> {
        let mut at_m = self.at_m;
        at_m[axis] += step_m;
        self.read(at_m)
    }
}

#[test]
fn every_face_of_the_workspace_has_its_margin() {
    let device = stylus();
    let margin_m = 0.1 * (device.workspace_high_m - device.workspace_low_m);
    for axis in 0..3 {
        for (face_m, out) in
            [(device.workspace_low_m[axis] - margin_m[axis], -1.0), (device.workspace_high_m[axis] + margin_m[axis], 1.0)]
        {
            for (beyond_m, inside) in [(-1e-5, true), (1e-5, false), (1.0, false)] {
                let mut at_m = Vector3::zeros();
                at_m[axis] = face_m + out * beyond_m;
                let answer = Gate::new().read(at_m);
                assert_eq!(answer.is_ok(), inside, "axis {axis}, {at_m}");
                assert!(inside || answer == Err(Fault::OutOfWorkspace));
            }
        }
    }
}

#[test]
fn a_reading_that_is_not_finite_or_not_good_is_a_fault_on_every_axis() {
    for axis in 0..3 {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut gate = Gate::believing();
            assert_eq!(gate.step(axis, bad), Err(Fault::PoseNotFinite));
        }
    }
    let mut gate = Gate::believing();
    let failed = Sensed { position_m: Vector3::zeros(), sequence: 5, status: SensorStatus::Failed };
    assert_eq!(gate.gate.admit(&gate.limits, &failed, false), Err(Fault::SensorFault));
}

#[test]
fn the_last_good_pose_is_held_for_two_ticks_without_a_reading() {
    let mut gate = Gate::believing();
    for _ in 0..5 {
        let at_m = gate.read(gate.at_m + Vector3::new(0.1e-3, 0.0, 0.0)).unwrap().position_m;
        for ticks in 1..=2 {
            assert_eq!(gate.repeat(), Ok(Pose { position_m: at_m, held: true, ticks }));
        }
    }
    assert_eq!(gate.repeat(), Err(Fault::PoseStale));
    assert_eq!(gate.repeat().map(|pose| pose.held), Ok(false), "after a fault any number is a first one");
    // a jump from a pose that was accepted: the first one is held, the second is a fault
    let mut blind = Gate::believing();
    blind.at_m.x = 1.0;
    blind.sequence += 1;
    assert_eq!(blind.repeat().map(|pose| pose.held), Ok(true), "one jump is a glitch");
    assert_eq!(blind.step(0, 0.0), Err(Fault::OverSpeed));
}

#[test]
fn a_sequence_number_may_wrap_and_must_not_go_back() {
    for (first, second, held) in [
        (7, 8, false),
        (7, 7, true),
        (7, 6, true),
        (u32::MAX, 0, false),
        (0, u32::MAX, true),
        (0, 0x7FFF_FFFF, false),
        (0, 1 << 31, true),
    ] {
        let mut gate = Gate::new();
        gate.sequence = first;
        gate.repeat().unwrap();
        gate.sequence = second;
        assert_eq!(gate.repeat().map(|pose| pose.held), Ok(held), "{first} then {second}");
    }
}

#[test]
fn speed_is_measured_from_the_last_believed_pose_over_the_time_since() {
    // 1.5 m/s: 1.5 mm per tick
    for (missing, step_m, believed) in [
        (0_u8, 1.45e-3, true),
        (0, 1.55e-3, false),
        (1, 2.95e-3, true),
        (1, 3.05e-3, false),
        (2, 4.45e-3, true),
        (2, 4.55e-3, false),
    ] {
        let mut gate = Gate::believing();
        (0..missing).for_each(|_| _ = gate.repeat().unwrap());
        let pose = gate.step(1, step_m).unwrap();
        assert_eq!(!pose.held, believed, "{missing} missing, {step_m} m");
        assert!(believed || pose.position_m == Vector3::zeros(), "the last good pose is held");
    }
    // two counts of an encoder say nothing about speed
    let device = palpate::haptic::device::DeviceSpec { count_m: 0.2e-3, ..stylus() };
    for (step_m, believed) in [(1.85e-3, true), (1.95e-3, false)] {
        let mut gate =
            Gate { limits: LoopLimits::build(&LoopLimitSettings::DESKTOP, &device, TICK_S).unwrap(), ..Gate::believing() };
        assert_eq!(!gate.step(1, step_m).unwrap().held, believed, "{step_m} m");
    }
}

#[test]
fn periods_without_a_cycle_are_time_as_well() {
    let mut gate = Gate::believing();
    gate.gate.skip(2);
    assert!(!gate.step(0, 4.4e-3).unwrap().held);
    assert!(gate.step(0, 4.4e-3).unwrap().held, "and are used up");
}

#[test]
fn one_glitch_is_held_two_are_a_fault_while_a_force_acts() {
    for force_acts in [true, false] {
        let mut gate = Gate { force_acts, ..Gate::believing() };
        for _ in 0..2 {
            assert!(gate.step(2, 20e-3).unwrap().held);
            assert!(!gate.step(2, -20e-3).unwrap().held, "there and back is one glitch");
        }
        assert!(gate.step(2, 20e-3).unwrap().held);
        match force_acts {
            true => assert_eq!(gate.step(2, 10e-3), Err(Fault::OverSpeed)),
            false => assert_eq!(gate.step(2, 10e-3).map(|pose| pose.held), Ok(false), "without a force the hand is followed"),
        }
    }
}

#[test]
fn after_a_fault_the_next_good_reading_is_believed_where_it_is() {
    let mut gate = Gate::believing();
    gate.step(0, f32::NAN).unwrap_err();
    gate.sequence = gate.sequence.wrapping_sub(10);
    assert_eq!(gate.read(Vector3::new(0.05, 0.0, 0.0)).map(|pose| pose.held), Ok(false));
}

/// Moves along an axis in steps [m] that end at a position [m], and returns the step at which the
/// gate reports a fault. A step of zero repeats the reading.
fn stops(axis: usize, from_m: f32, steps_m: &[f32], force_acts: bool) -> Option<usize> {
    let mut gate = Gate { force_acts, ..Gate::new() };
    let mut at_m = Vector3::zeros();
    at_m[axis] = from_m - steps_m.iter().sum::<f32>();
    gate.read(at_m).unwrap();
    steps_m.iter().position(|step_m| gate.step(axis, *step_m) == Err(Fault::SensorFault))
}

#[test]
fn an_axis_that_stops_dead_from_speed_is_a_fault_at_the_third_equal_reading() {
    let (fast, slow) = (0.25e-3, 0.15e-3);
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let run = |steps: &[f32], force_acts| {
                let steps: Vec<f32> = steps.iter().map(|s| s * sign).collect();
                stops(axis, 0.0, &steps, force_acts)
            };
            assert_eq!(run(&[fast, fast, fast, 0.0, 0.0, 0.0, 0.0], true), Some(5), "axis {axis}");
            assert_eq!(run(&[fast, fast, fast, 0.0, 0.0, 0.0], false), None, "without a force it does no harm");
            assert_eq!(run(&[fast, fast, 0.0, 0.0, 0.0, 0.0], true), None, "two fast readings are a glitch");
            assert_eq!(run(&[slow, slow, slow, slow, 0.0, 0.0, 0.0, 0.0], true), None, "slow hands stop");
            assert_eq!(run(&[fast, fast, fast, 0.0, 0.0, slow, 0.0, 0.0, 0.0], true), None, "two equal readings only");
            assert_eq!(run(&[fast, fast, fast, slow, 0.0, 0.0, 0.0, 0.0], true), None, "it slowed down");
            assert_eq!(run(&[fast, fast, -fast, 0.0, 0.0, 0.0, 0.0], true), None, "it turned round");
            assert_eq!(run(&[fast, fast, 0.0, fast, 0.0, 0.0, 0.0], true), None, "equal readings end the motion");
            assert_eq!(run(&[fast, fast, 0.0, fast, fast, fast, 0.0, 0.0, 0.0], true), Some(8), "and it may begin anew");
        }
    }
}

#[test]
fn a_hard_stop_within_two_millimetres_of_the_end_is_no_fault() {
    let device = stylus();
    let fast = 0.25e-3;
    for axis in 0..3 {
        for (end_m, out) in [(device.workspace_low_m[axis], -1.0), (device.workspace_high_m[axis], 1.0)] {
            for (before_m, fault) in [(2.2e-3, true), (1.8e-3, false), (0.0, false), (-1e-3, false)] {
                let steps = [out * fast, out * fast, out * fast, out * fast, 0.0, 0.0, 0.0, 0.0];
                let found = stops(axis, end_m - out * before_m, &steps, true);
                assert_eq!(found.is_some(), fault, "axis {axis}, {before_m} m before {end_m} m");
            }
        }
    }
}

#[test]
fn one_axis_that_sticks_while_the_others_move_is_a_fault() {
    let mut gate = Gate::believing();
    for _ in 0..4 {
        gate.read(gate.at_m + Vector3::new(0.3e-3, 0.3e-3, 0.0)).unwrap();
    }
    let faults = (0..3).map(|_| gate.read(gate.at_m + Vector3::new(0.3e-3, 0.0, 0.0))).filter(Result::is_err).count();
    assert_eq!(faults, 1);
}

#[test]
fn fast_means_two_and_a_half_counts_where_an_encoder_is_coarse() {
    let device = palpate::haptic::device::DeviceSpec { count_m: 0.2e-3, ..stylus() };
    for (step_m, fault) in [(0.4e-3, false), (0.6e-3, true)] {
        let mut gate =
            Gate { limits: LoopLimits::build(&LoopLimitSettings::DESKTOP, &device, TICK_S).unwrap(), ..Gate::believing() };
        (0..3).for_each(|_| _ = gate.step(0, step_m).unwrap());
        let found = (0..4).any(|_| gate.step(0, 0.0).is_err());
        assert_eq!(found, fault, "{step_m} m per tick");
    }
}
