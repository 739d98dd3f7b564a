//! A probe that speeds up against the force: which cases are a fault, and which a hand can cause.

use palpate::haptic::cycle::Command;
use palpate::haptic::runaway::Runaway;
use palpate::haptic::seen::{Monitor, Seen};
use palpate::{Fault, Output, Vector3};

use crate::bench::{Bench, TICK_S, limits, pushing};

/// Runs one tick: a displacement [m] against a force [N].
fn tick(runaway: &mut Runaway, displacement_m: Vector3<f32>, normal: Vector3<f32>, sent_n: Vector3<f32>) -> Result<(), Fault> {
    let limits = limits();
    let output = Output { normal, ..Output::NONE };
    runaway.judge(&Seen { displacement_m, output, sent_n, ..Seen::none(&limits) })
}

/// Runs a probe that is pushed outwards along `normal` with this force [N] while it moves in at
/// these speeds [m/s], tick by tick; returns the tick of the fault.
fn pushed(normal: Vector3<f32>, force_n: f32, speeds: impl Iterator<Item = f32>) -> Option<usize> {
    let mut runaway = Runaway::default();
    let mut judge = |inward: f32| tick(&mut runaway, normal * (-inward * TICK_S), normal, normal * force_n);
    speeds.enumerate().find(|(_, inward)| judge(*inward) == Err(Fault::Runaway)).map(|(tick, _)| tick)
}

/// Speeds that go from one speed to another within 50 ticks, then constant [m/s].
fn gains(from: f32, to: f32) -> impl Iterator<Item = f32> {
    (0..250_u8).map(move |n| from + (to - from) * (f32::from(n) / 50.0).min(1.0))
}

#[test]
fn half_a_metre_per_second_gained_against_half_a_newton_is_a_fault() {
    for normal in [Vector3::x(), -Vector3::y(), Vector3::new(0.6, 0.0, 0.8)] {
        for (from, to, fault) in [(0.0, 0.55, true), (0.0, 0.45, false), (0.3, 0.9, true), (0.3, 0.75, false), (0.9, 0.1, false)]
        {
            assert_eq!(pushed(normal, 1.0, gains(from, to)).is_some(), fault, "{from} to {to} m/s");
        }
        for (force_n, fault) in [(0.51, true), (0.49, false), (-1.0, false), (-3.0, false)] {
            assert_eq!(pushed(normal, force_n, gains(0.0, 0.8)).is_some(), fault, "{force_n} N");
        }
    }
}

#[test]
fn a_normal_that_turns_away_hides_no_speed_that_was_gained() {
    let mut runaway = Runaway::default();
    let found = (0..250_u8).find(|n| {
        let (speed, angle) = ((0.02 * f32::from(*n)).min(0.9), (0.1 * f32::from(*n)).min(1.2));
        let normal = Vector3::new(angle.sin(), 0.0, angle.cos());
        tick(&mut runaway, Vector3::z() * (-speed * TICK_S), normal, normal).is_err()
    });
    assert!(found.is_some_and(|n| n < 80), "{found:?}: along the turned normal, a third of it is left");
}

#[test]
fn a_hand_that_comes_to_rest_within_twenty_five_millimetres_is_no_runaway() {
    // 1 m/s and more is gained; the travel decides
    for (ticks, fault) in [(18_usize, false), (24, true)] {
        let speeds = (0..200).map(|n| {
            if n < 5 {
                0.0
            } else if n < 5 + ticks {
                1.2
            } else {
                0.0
            }
        });
        assert_eq!(pushed(Vector3::z(), 2.0, speeds).is_some(), fault, "{} mm", 1.2 * ticks as f32);
    }
}

#[test]
fn a_reading_that_comes_late_is_no_speed_that_is_gained() {
    // every tenth reading is missing, and the next displacement is twice as long: the low-pass acts
    // during the whole contact, not only at its beginning
    for m_per_s in [0.4, 0.6, 0.9] {
        let speeds = (0..250).map(|n| match n % 10 {
            8 => 0.0,
            9 => 2.0 * m_per_s,
            _ => m_per_s,
        });
        assert_eq!(pushed(Vector3::z(), 1.0, speeds), None, "{m_per_s} m/s");
    }
}

#[test]
fn a_force_that_was_interrupted_starts_the_count_anew() {
    let mut runaway = Runaway::default();
    for n in 0..400 {
        // 0.8 m/s are gained, but the force vanishes for a tick after every 20 mm
        let inward = if n % 25 < 5 { 0.0 } else { 1.0 };
        let force_n = if n % 25 == 24 { 0.0 } else { 1.0 };
        let answer = tick(&mut runaway, Vector3::new(0.0, 0.0, -inward * TICK_S), Vector3::z(), Vector3::new(0.0, 0.0, force_n));
        assert_eq!(answer, Ok(()), "tick {n}");
    }
}

#[test]
fn what_a_late_tick_catches_up_with_is_no_speed_that_is_gained() {
    let mut bench = Bench::new(100.0).idle();
    bench.device.sensed.position_m.z = 0.05;
    bench.ticks(3);
    bench.arm();
    bench.ticks(600);
    let step = |bench: &mut Bench, m_per_s: f32, late_ticks: u16| {
        bench.device.sensed.position_m.z -= m_per_s * TICK_S * f32::from(late_ticks + 1);
        bench.run(Command { late_ticks, ..Command::HEARD })
    };
    (0..8).for_each(|_| _ = step(&mut bench, 1.40, 0));
    bench.wall.answer = Some(pushing(1e-3, 1.0));
    (0..4).for_each(|_| _ = step(&mut bench, 1.40, 0));
    (0..22).for_each(|_| assert_eq!(step(&mut bench, 1.45, 0).fault, None));
    for n in 0..8 {
        assert_eq!(step(&mut bench, 1.45, u16::from(n % 2 == 0)).fault, None, "tick {n}");
        // half of the force after each late tick is still strong enough for a gain in speed to
        // count
        assert!(bench.device.drive_n.is_some_and(|force_n| force_n.z > 0.5), "tick {n}: {:?}", bench.device.drive_n);
    }
}

#[test]
fn late_ticks_hide_no_runaway() {
    let faulted = |late: &[u16]| {
        let mut bench = Bench::new(100.0).idle();
        bench.device.sensed.position_m.z = 0.05;
        bench.ticks(3);
        bench.arm();
        bench.ticks(600);
        // a steady press first, which proves the sign
        bench.wall.answer = Some(pushing(20e-3, 1.5));
        for _ in 0..40 {
            bench.device.sensed.position_m.z -= 0.1 * TICK_S;
            bench.tick();
        }
        bench.wall.answer = None;
        bench.ticks(50);
        bench.wall.answer = Some(pushing(20e-3, 1.5));
        (0..200_u16).find(|n| {
            let late_ticks = u16::from(late.contains(n));
            let m_per_s = 0.6 * f32::from(*n).min(40.0) / 40.0;
            bench.device.sensed.position_m.z -= m_per_s * TICK_S * f32::from(late_ticks + 1);
            match bench.run(Command { late_ticks, ..Command::HEARD }).fault {
                None => false,
                fault => fault == Some(Fault::Runaway) || panic!("{fault:?} in tick {n}"),
            }
        })
    };
    let in_time = faulted(&[]).unwrap();
    assert!((50..80).contains(&in_time), "tick {in_time}");
    // as many late ticks as are tolerated, just before that tick
    let late = [8, 6, 4, 2].map(|before| in_time - before);
    let found = faulted(&late).unwrap();
    assert!((in_time - 8..=in_time).contains(&found), "tick {found} instead of {in_time}");
}

#[test]
fn speed_gained_in_a_slide_is_no_runaway() {
    // 0.8 m/s are gained along the normal; the sideways travel decides
    for (aside, fault) in [(0.0, true), (0.3, true), (0.7, false), (2.0, false)] {
        let mut runaway = Runaway::default();
        let found = gains(0.0, 0.8).any(|inward| {
            let moved_m = Vector3::new(aside * inward, 0.0, -inward) * TICK_S;
            tick(&mut runaway, moved_m, Vector3::z(), Vector3::z()).is_err()
        });
        assert_eq!(found, fault, "{aside} aside of one into the tissue");
    }
}
