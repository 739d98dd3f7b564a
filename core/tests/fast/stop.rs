//! How a force ends: by request, by silence, by a limit that is lowered.

use palpate::haptic::cycle::{Ask, Command};
use palpate::haptic::device::DeviceSpec;
use palpate::haptic::limits::LoopLimitSettings;
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Vector3};

use crate::bench::{Bench, CLEAR_M, set, stylus};

#[test]
fn stop_takes_the_force_away_evenly_in_its_time() {
    let mut bench = Bench::new(400.0).active();
    bench.press_n(2.4);
    let mut last_n = bench.ask(Ask::Stop).applied_n.z;
    assert_eq!(bench.cycle.mode(), Mode::SafeRamp);
    assert!((last_n - 2.4).abs() < 0.03, "{last_n}");
    for tick in 1..120_u8 {
        let record = bench.tick();
        let even_n = 2.4 * f32::from(120 - tick) / 120.0;
        assert!((record.applied_n.z - even_n).abs() < 2e-3, "tick {tick}: {} N, evenly {even_n}", record.applied_n.z);
        assert!(record.applied_n.z < last_n && record.mode == Mode::SafeRamp);
        last_n = record.applied_n.z;
    }
    let record = bench.tick();
    assert_eq!((record.mode, record.applied_n, bench.device.drive_n), (Mode::Idle, Vector3::zeros(), None));
    let rendered = bench.wall.rendered;
    bench.tick();
    assert_eq!(bench.wall.rendered, rendered, "the patch does not run in Idle");
}

#[test]
fn a_force_that_fell_while_it_ramps_does_not_rise_again() {
    let mut bench = Bench::new(400.0).active();
    bench.press_n(2.4);
    bench.ask(Ask::Stop);
    bench.ticks(20);
    bench.move_to(-2.5e-3, 0.1);
    let low_n = bench.tick().applied_n.norm();
    assert!(low_n > 0.5 && low_n < 1.05, "{low_n}");
    let mut last_n = low_n;
    for step in 0..7 {
        let record = bench.at(-2.5e-3 - 0.5e-3 * step as f32);
        assert!(record.applied_n.norm() <= last_n + 1e-6, "{} after {last_n}", record.applied_n);
        last_n = record.applied_n.norm();
    }
}

#[test]
fn without_a_force_the_ramp_ends_at_once() {
    let mut bench = Bench::new(400.0).active();
    assert_eq!(bench.ask(Ask::Stop).mode, Mode::Idle);
    let mut bench = Bench::new(400.0).idle();
    bench.ask(Ask::Arm);
    assert_eq!(bench.ask(Ask::Stop).mode, Mode::Idle, "arming stops as well");
}

#[test]
fn twenty_silent_ticks_lose_the_host_and_a_sign_of_life_starts_the_count_anew() {
    let mut bench = Bench::new(400.0).active();
    bench.press_n(1.0);
    let silent = Command::default();
    for _ in 0..3 {
        assert!((0..19).all(|_| bench.run(silent).mode == Mode::Active));
        bench.tick();
    }
    let lost = (1..100).find(|_| bench.run(silent).mode == Mode::SafeRamp);
    assert_eq!(lost, Some(20));
    // a host that comes back does not get its force back
    assert_eq!(bench.ticks(200).mode, Mode::Idle);
    // silence ends arming as well; it does not change `Idle`
    bench.move_to(CLEAR_M, 0.1);
    bench.ask(Ask::Arm);
    let lost = (1..100).find(|_| bench.run(silent).mode == Mode::Idle);
    assert_eq!(lost, Some(20));
    assert_eq!((bench.run(silent).mode, bench.run(silent).fault), (Mode::Idle, None));
}

#[test]
fn a_host_is_silent_only_as_long_as_the_settings_say() {
    let mut bench = Bench::with(400.0, stylus(), |s| {
        s.arming.silence_ticks = 7;
        s.arming.ramp_ticks = 40;
    })
    .active();
    bench.press_n(1.0);
    let lost = (1..100).find(|_| bench.run(Command::default()).mode == Mode::SafeRamp);
    assert_eq!(lost, Some(7));
    let over = (1..100).find(|_| bench.tick().mode == Mode::Idle);
    assert_eq!(over, Some(40));
}

#[test]
fn limits_are_lowered_under_force_and_never_raised() {
    let mut bench = Bench::new(400.0).active();
    bench.press_n(2.0);
    let lower = LoopLimitSettings { max_force_n: 1.2, ..LoopLimitSettings::DESKTOP };
    bench.cycle.lower_limits(&lower).unwrap();
    let record = bench.tick();
    assert!((record.applied_n.z - 1.2).abs() < 1e-5 && set(&record, ClampFlags::FORCE), "{}", record.applied_n);
    assert!(bench.cycle.lower_limits(&LoopLimitSettings::DESKTOP).is_err());
    assert_eq!(bench.cycle.limits(), &lower);
}

#[test]
fn held_poses_and_growth_are_told() {
    // a handle so heavy that the account pays for the push at once
    let mut bench = Bench::with(400.0, DeviceSpec { mass_kg: 1.0, ..stylus() }, |_| ()).active();
    assert!(set(&bench.repeat(Command::HEARD), ClampFlags::HELD));
    assert!(!set(&bench.tick(), ClampFlags::HELD));
    bench.wall.answer = Some(crate::bench::pushing(5e-3, 2.0));
    let record = bench.at(CLEAR_M + 1e-5);
    assert!(set(&record, ClampFlags::SLEW) && !set(&record, ClampFlags::FORCE) && !set(&record, ClampFlags::GAIN));
    assert!((record.applied_n.z - 0.5).abs() < 1e-5, "{}", record.applied_n);
}

#[test]
fn an_operator_who_leaves_ramps_the_force_down_and_nothing_arms_without_one() {
    let absent = Command { operator_absent: true, ..Command::HEARD };
    let mut bench = Bench::new(400.0).active();
    bench.press_n(1.0);
    assert_eq!(bench.run(absent).mode, Mode::SafeRamp);
    assert_eq!(bench.ticks(200).mode, Mode::Idle, "nobody who comes back gets the force back");
    bench.move_to(CLEAR_M, 0.1);
    let record = bench.run(Command { asked: Some(Ask::Arm), ..absent });
    assert!(record.refused && record.mode == Mode::Idle);
    assert!(!bench.ask(Ask::Arm).refused);
    assert_eq!(bench.run(absent).mode, Mode::Idle, "arming ends as well");
    bench.arm();
}
