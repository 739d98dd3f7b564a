//! A defective loop is detected. The loop's outputs are changed into those of a loop with one
//! defect at a time, over a script that contains every situation, and the checks must report it.
//! Without a defect they must report nothing.

use palpate::haptic::cycle::{Ask, Command};
use palpate::haptic::limits::LoopLimitSettings;
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Vector3};
use palpate_loop::closed_loop::watch::Tick;

use crate::haptic_invariants::rig::{Defect, NORMAL, Rig};

/// Runs a script that contains every situation at least once.
fn script(defect: Option<Defect>) -> Rig {
    let mut rig = Rig::at(3e-3);
    rig.defect = defect;
    rig.hold(1);
    rig.arm(); // inside the tissue
    rig.hold(200);
    rig.go(-6e-3, 0.1);
    rig.hold(700);
    rig.go(12e-3, 0.2); // saturated, then relieved
    rig.hold(300);
    rig.go(-3e-3, 0.3);
    rig.hold(20);
    rig.go(3e-3, 0.1);
    let seen_m = rig.device.reading.position_m;
    rig.device.reading.position_m = seen_m + Vector3::new(0.02, 0.0, 0.0); // a single glitch
    rig.hold(1);
    rig.device.reading.position_m = seen_m;
    rig.hold(10);
    rig.tick(Command::HEARD, false); // a single stale reading
    rig.hold(10);
    for _ in 0..170 {
        rig.tick(Command::default(), true); // the host is silent under force
    }
    rig.ask(Ask::Arm);
    rig.hold(50);
    rig.go(-5e-3, 0.1);
    rig.hold(700);
    rig.go(4e-3, 0.1);
    rig.ask(Ask::Stop);
    rig.hold(200);
    rig.go(-5e-3, 0.1);
    rig.ask(Ask::Arm);
    rig.hold(700);

    let broken_by: [fn(&mut Rig); 5] = [
        |rig| rig.device.reading.position_m.z = f32::NAN,
        |rig| rig.tissue.sick_n = Some(Vector3::new(f32::NAN, 0.0, 0.0)),
        |rig| rig.device.reading.position_m += NORMAL * 8e-3,
        |rig| {
            rig.tick(Command { found: Some(palpate::Fault::SupplyLow), ..Command::HEARD }, true);
        },
        |rig| {
            for _ in 0..5 {
                rig.tick(Command::HEARD, false);
            }
        },
    ];
    for break_it in broken_by {
        rig.go(4e-3, 0.1);
        rig.hold(20);
        break_it(&mut rig);
        rig.hold(1);
        if rig.cycle.mode() != Mode::Fault {
            break_it(&mut rig);
            rig.hold(3);
        }
        rig.ask(Ask::Clear); // before the fault may be cleared
        rig.recover();
    }
    rig.go(5e-3, 0.1);
    rig.cycle.lower_limits(&LoopLimitSettings { max_force_n: 1.0, ..LoopLimitSettings::DESKTOP }).unwrap();
    rig.hold(20);
    rig.go(-3e-3, 0.1);
    rig.go(6e-3, 1.45); // faster than the slew limit, and then a turn that no hand makes
    rig.go(-3e-3, 1.4);
    rig
}

/// Reports a force and applies it to the device.
fn give(tick: &mut Tick, force_n: Vector3<f32>) {
    tick.telemetry.applied_n = force_n;
    tick.got_n = Some(force_n);
}

/// Continues as if no fault had occurred.
fn carry_on(before: &Tick, now: &mut Tick) {
    (now.telemetry.mode, now.telemetry.fault) = (before.telemetry.mode, before.telemetry.fault);
    give(now, before.force_n());
}

fn clipped(force_n: Vector3<f32>, most_n: f32) -> Vector3<f32> {
    force_n.map(|c| c.clamp(-most_n, most_n))
}

fn forced(tick: &Tick) -> bool {
    matches!(tick.telemetry.mode, Mode::Active | Mode::Degraded)
}

/// Name of each defect, and the change that it makes to a tick's results.
const DEFECTS: [(&str, Defect); 28] = [
    ("no force limit", |_, now| {
        if forced(now) {
            give(now, now.telemetry.wanted_n);
        }
    }),
    ("limit of each axis instead of the vector", |_, now| {
        if now.telemetry.limiters.contains(ClampFlags::FORCE) {
            give(now, clipped(now.telemetry.wanted_n, 0.57 * now.limits.max_force_n));
        }
    }),
    ("no slew limit", |_, now| {
        if now.telemetry.limiters.contains(ClampFlags::SLEW) {
            give(now, now.telemetry.wanted_n * (now.limits.max_force_n / now.telemetry.wanted_n.norm()).min(1.0));
        }
    }),
    ("a slew limit twice too high", |before, now| {
        if now.telemetry.limiters.contains(ClampFlags::SLEW) {
            give(now, before.force_n() + (now.telemetry.wanted_n - before.force_n()).cap_magnitude(1.0));
        }
    }),
    ("a lowered limit is forgotten", |_, now| {
        if forced(now) && now.limits.max_force_n < 2.0 {
            give(now, now.telemetry.wanted_n);
        }
    }),
    ("a NaN limit lets all pass", |_, now| {
        if forced(now) {
            give(now, now.telemetry.wanted_n * f32::NAN);
        }
    }),
    ("a NaN pose is ignored", |before, now| {
        if now.reading.position_m.z.is_nan() && forced(before) {
            carry_on(before, now);
        }
    }),
    ("the board's finding is ignored", |before, now| {
        if now.command.found.is_some() {
            carry_on(before, now);
        }
    }),
    ("fault told, device not released", |before, now| {
        if now.telemetry.mode == Mode::Fault {
            give(now, before.force_n());
        }
    }),
    ("force told zero, device keeps the last", |before, now| {
        if now.telemetry.mode == Mode::Fault && forced(before) {
            now.got_n = before.got_n;
        }
    }),
    ("a fault ends by itself", |before, now| {
        if before.telemetry.mode == Mode::Fault {
            (now.telemetry.mode, now.telemetry.fault) = (Mode::Idle, None);
        }
    }),
    ("a fault is cleared at once", |before, now| {
        if before.telemetry.mode == Mode::Fault && now.command.asked == Some(Ask::Clear) {
            (now.telemetry.mode, now.telemetry.fault) = (Mode::SelfTest, None);
        }
    }),
    ("a later fault replaces the first", |before, now| {
        if before.telemetry.mode == Mode::Fault && now.telemetry.mode == Mode::Fault {
            now.telemetry.fault = Some(palpate::Fault::DeadlineMissed);
        }
    }),
    ("a fault's mode is kept without its reason", |_, now| now.telemetry.fault = None),
    ("old poses are rendered", |before, now| {
        if now.reading.sequence == before.reading.sequence && forced(before) {
            carry_on(before, now);
        }
    }),
    ("speed is no fault", |before, now| {
        if now.telemetry.fault == Some(palpate::Fault::OverSpeed) {
            carry_on(before, now);
        }
    }),
    ("force while arming", |_, now| {
        if now.telemetry.mode == Mode::Arming {
            give(now, now.telemetry.wanted_n);
        }
    }),
    ("arming without waiting", |_, now| {
        if now.telemetry.mode == Mode::Arming {
            now.telemetry.mode = Mode::Active;
            give(now, Vector3::zeros());
        }
    }),
    ("force without arming", |_, now| {
        if now.telemetry.mode == Mode::Idle {
            now.telemetry.mode = Mode::Active;
            give(now, Vector3::zeros());
        }
    }),
    ("the host's silence is not heard", |before, now| {
        if !now.command.heard {
            carry_on(before, now);
        }
    }),
    ("a ramp that does not fall", |before, now| {
        if now.telemetry.mode == Mode::SafeRamp {
            give(now, before.force_n() * 1.001);
        }
    }),
    ("a rest of force in free space", |_, now| {
        if forced(now) && now.telemetry.output.depth_m == 0.0 {
            give(now, NORMAL * 1e-3);
        }
    }),
    ("damping in free space", |before, now| {
        if forced(now) && now.telemetry.output.depth_m == 0.0 {
            give(now, (before.telemetry.position_m - now.telemetry.position_m) * 300.0);
        }
    }),
    ("damping that sticks", |before, now| {
        if forced(now) && now.telemetry.output.depth_m > 0.0 {
            let displacement_m = now.telemetry.position_m - before.telemetry.position_m;
            give(now, now.telemetry.applied_n - displacement_m * 2000.0);
        }
    }),
    ("the force points in", |_, now| {
        if forced(now) {
            give(now, -now.telemetry.applied_n);
        }
    }),
    ("a position that was not read is reported", |_, now| now.telemetry.position_m += NORMAL * 1e-4),
    ("the force of a press is kept while the hand leaves", |before, now| {
        let leaves = (now.telemetry.position_m - before.telemetry.position_m).dot(&NORMAL) > 0.0;
        if forced(now) && leaves && now.telemetry.output.depth_m > 0.0 {
            give(now, before.force_n());
        }
    }),
    ("the tick count stands still", |before, now| now.telemetry.tick = before.telemetry.tick),
];

#[test]
fn the_script_is_clean_and_meets_every_mode_and_every_limiter_of_the_loop() {
    let rig = script(None);
    rig.expect_clean();
    assert!(Mode::ALL.iter().all(|m| rig.modes.contains(m)), "{:?}", rig.modes);
    for limiter in [ClampFlags::FORCE, ClampFlags::SLEW, ClampFlags::HELD, ClampFlags::GAIN, ClampFlags::ENERGY] {
        assert!(rig.limiters.contains(limiter), "{limiter:?}");
    }
}

#[test]
fn every_planted_defect_is_noticed() {
    let missed: Vec<_> =
        DEFECTS.iter().filter(|(_, defect)| script(Some(*defect)).broken.is_empty()).map(|(name, _)| name).collect();
    assert!(missed.is_empty(), "not noticed: {missed:?}");
}

/// Presses again and again; while the hand leaves, the tissue pushes with 2 N more than its spring
/// force. Returns whether the hand was given too much.
fn pushed_out(mut rig: Rig, contacts: u32) -> bool {
    for _ in 0..contacts {
        rig.go(3e-3, 0.1);
        while rig.device.reading.position_m.dot(&NORMAL) < -0.5e-3 {
            rig.tissue.sick_n = Some(NORMAL * 2.0);
            rig.device.reading.position_m += NORMAL * 0.5e-3;
            rig.tick(Command::HEARD, true);
        }
        rig.go(-3e-3, 0.1);
        rig.hold(30);
    }
    // what the bound allows may shake the hand (I15): the tissue is sick
    assert!(rig.broken.iter().all(|b| matches!(b.id, "I11" | "I15")), "{:?}", rig.broken);
    rig.broken.iter().any(|b| b.id == "I11")
}

#[test]
fn a_hand_that_is_given_energy_by_every_contact_is_noticed_at_every_delay() {
    for delay_ticks in 0..=7 {
        assert!(!pushed_out(Rig::undamped(delay_ticks, true), 30), "{delay_ticks} ticks");
        assert!(pushed_out(Rig::undamped(delay_ticks, false), 30), "{delay_ticks} ticks, without the account");
    }
}

#[test]
fn the_force_of_a_press_that_is_kept_while_the_hand_leaves_is_noticed() {
    let keeps: Defect = |before, now| {
        let leaves = (now.telemetry.position_m - before.telemetry.position_m).dot(&NORMAL) > 0.0;
        if leaves && now.telemetry.output.depth_m > 0.0 {
            now.got_n = before.got_n;
        }
    };
    for (defect, noticed) in [(None, false), (Some(keeps), true)] {
        let mut rig = Rig::delayed(0);
        rig.defect = defect;
        for _ in 0..5 {
            rig.go(5e-3, 0.1);
            rig.go(-3e-3, 0.1);
        }
        assert_eq!(rig.broken.iter().any(|b| b.id == "I11"), noticed, "{:?}", rig.broken);
    }
}

#[test]
fn a_full_force_before_the_ramp_in_ends_is_noticed() {
    let full: Defect = |_, now| {
        if forced(now) {
            give(now, now.telemetry.wanted_n);
        }
    };
    for (defect, noticed) in [(None, false), (Some(full), true)] {
        let mut rig = Rig::at(-5e-3);
        rig.arm();
        rig.hold(220);
        rig.defect = defect;
        rig.go(2e-3, 0.05);
        assert_eq!(rig.broken.iter().any(|b| b.what == "ramp-in"), noticed, "{:?}", rig.broken);
    }
}
