//! From power-on to a force: when it may act, and how it begins.

use palpate::haptic::cycle::{Ask, Command};
use palpate::haptic::device::{DeviceSpec, SensorStatus};
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Fault, Output, Vector3};

use crate::bench::{Bench, CLEAR_M, pushing, set, stylus};

#[test]
fn start_up_goes_through_every_mode_and_renders_from_arming_on() {
    let mut bench = Bench::new(400.0);
    assert_eq!((bench.cycle.mode(), bench.wall.rendered), (Mode::Boot, 0));
    assert_eq!(bench.tick().mode, Mode::Boot, "nothing happens by itself");
    for (asked, mode) in [(Ask::Booted, Mode::SelfTest), (Ask::TestPassed, Mode::Idle)] {
        let record = bench.ask(asked);
        assert_eq!((record.mode, record.refused, bench.wall.rendered), (mode, false, 0));
    }
    let resets = bench.wall.resets;
    let record = bench.ask(Ask::Arm);
    assert_eq!((record.mode, record.refused), (Mode::Arming, false));
    assert_eq!((bench.wall.resets, bench.wall.rendered), (resets + 1, 1), "the patch starts at rest");
    let record = bench.tick();
    assert_eq!((record.tick, record.position_m), (5, Vector3::new(0.0, 0.0, CLEAR_M)));
    assert!(bench.device.drive_n.is_none(), "no force while arming");
}

#[test]
fn a_request_that_the_mode_does_not_know_is_refused() {
    let mut bench = Bench::new(400.0);
    for asked in [Ask::TestPassed, Ask::Arm, Ask::Stop, Ask::Clear] {
        assert!(bench.ask(asked).refused, "{asked:?} in Boot");
        assert_eq!(bench.cycle.mode(), Mode::Boot);
    }
    assert!(!bench.tick().refused, "nothing was asked");
    let mut bench = bench.idle();
    assert!(bench.ask(Ask::Stop).refused && bench.ask(Ask::Booted).refused);
    // a request in the tick of a fault is not followed either
    let failed = Command { asked: Some(Ask::Arm), found: Some(Fault::SupplyLow), ..Command::HEARD };
    assert!(bench.run(failed).refused);
}

#[test]
fn a_request_that_is_refused_under_force_disturbs_no_contact() {
    let mut bench = Bench::new(400.0).idle();
    bench.arm();
    bench.ticks(10);
    bench.wall.answer = Some(pushing(1e-3, 1.0));
    bench.ticks(600);
    let (before, resets) = (bench.tick(), bench.wall.resets);
    for asked in [Ask::Arm, Ask::Clear] {
        let record = bench.ask(asked);
        assert!(record.refused && record.applied_n == before.applied_n, "{asked:?}");
        assert_eq!(bench.wall.resets, resets, "{asked:?} leaves the tissue as it lies");
        assert!(bench.cycle.in_contact());
    }
    assert!(!bench.ask(Ask::Stop).refused);
    assert_eq!(bench.wall.resets, resets, "the force fades out of the tissue as it lies");
}

#[test]
fn a_hundred_calm_ticks_arm() {
    let mut bench = Bench::new(400.0).idle();
    assert_eq!(bench.arm(), 99, "the tick that asked is the first");
    assert_eq!(bench.tick().applied_n, Vector3::zeros());
    assert!(bench.device.drive_n.is_some(), "from now on the device is driven");
}

#[test]
fn contact_while_arming_starts_the_count_anew() {
    for touch in [pushing(1e-3, 0.0), pushing(0.0, 0.1), pushing(1e-3, 0.1), pushing(1e-3, 1.0)] {
        let mut bench = Bench::new(400.0).idle();
        bench.ask(Ask::Arm);
        bench.ticks(60);
        bench.wall.answer = Some(touch);
        let record = bench.ticks(200);
        assert_eq!((record.mode, record.applied_n), (Mode::Arming, Vector3::zeros()), "{touch:?}");
        assert!(bench.cycle.in_contact(), "a depth or a force alone is a contact");
        bench.wall.answer = None;
        let armed = (1..200).find(|_| bench.tick().mode == Mode::Active);
        assert_eq!(armed, Some(100));
        assert!(!bench.cycle.in_contact());
    }
}

#[test]
fn a_probe_that_starts_inside_the_tissue_is_not_armed() {
    let mut bench = Bench::new(400.0).idle();
    let mut buried = Output::NONE;
    buried.limiters.set(ClampFlags::BURIED);
    bench.wall.answer = Some(buried);
    bench.ask(Ask::Arm);
    assert_eq!(bench.ticks(500).mode, Mode::Arming);
}

#[test]
fn a_fast_probe_is_not_armed() {
    for (m_per_s, armed) in [(0.55, false), (0.45, true)] {
        let mut bench = Bench::with(400.0, stylus(), |s| s.arming.calm_ticks = 50).idle();
        bench.device.sensed.position_m.x = -0.05;
        bench.ticks(5);
        bench.ask(Ask::Arm);
        let found = (0..150).any(|_| {
            bench.device.sensed.position_m.x += m_per_s * 1e-3;
            bench.tick().mode == Mode::Active
        });
        assert_eq!(found, armed, "{m_per_s} m/s");
    }
}

#[test]
fn the_gain_rises_over_five_hundred_ticks_in_free_space_and_not_in_contact() {
    let mut bench = Bench::new(400.0).idle();
    bench.device.sensed.position_m.z = 0.1e-3;
    bench.ticks(5);
    bench.arm();
    // the tick in which the loop armed is one of the 500, although it still had the gain of the
    // mode before
    let record = bench.ticks(249);
    assert!(set(&record, ClampFlags::GAIN));
    let force_n = bench.press_n(2.0).applied_n.z;
    assert!((0.95..1.15).contains(&force_n), "half of 2 N: {force_n}");
    let record = bench.ticks(2_000);
    assert_eq!(record.applied_n.z, force_n, "the contact keeps the gain that it began with");
    assert!(set(&record, ClampFlags::GAIN));
    bench.move_to(CLEAR_M, 0.05);
    let record = bench.ticks(500);
    assert!(!set(&record, ClampFlags::GAIN), "full gain");
    assert!((bench.press_n(2.0).applied_n.z - 2.0).abs() < 1e-3);
    // a probe that touches at once begins with almost no force
    let mut bench = Bench::new(400.0).idle();
    bench.arm();
    bench.wall.answer = Some(pushing(5e-3, 2.0));
    assert!((0..300).all(|_| bench.tick().applied_n.norm() < 0.01));
}

#[test]
fn arming_anew_begins_at_no_gain() {
    let mut bench = Bench::new(400.0).active();
    bench.ask(Ask::Stop);
    bench.ticks(5);
    assert_eq!(bench.cycle.mode(), Mode::Idle);
    bench.arm();
    bench.wall.answer = Some(pushing(5e-3, 2.0));
    assert!((0..50).all(|_| bench.tick().applied_n.norm() < 0.01));
}

#[test]
fn the_device_gets_what_the_record_says_and_the_patch_what_was_sensed() {
    let mut bench = Bench::new(400.0).active();
    let record = bench.press_n(1.0);
    assert_eq!(bench.device.drive_n, Some(record.applied_n));
    assert_eq!((bench.wall.shown_m, record.position_m), (bench.device.sensed.position_m, bench.device.sensed.position_m));
    assert_eq!((record.wanted_n, record.fault), (record.applied_n, None));
    assert!((record.output.force_n.z - 1.0).abs() < 1e-4);
    assert_eq!(bench.cycle.limits().max_force_n, 3.0);
}

#[test]
fn damping_after_a_fault_begins_without_the_velocity_before_it() {
    // coarse counts let the velocity fade slowly
    let coarse = DeviceSpec { count_m: 1e-3, ..stylus() };
    let ticks_to_arm = |jumped_m: f32| {
        let mut bench = Bench::with(400.0, coarse, |s| {
            s.arming.calm_ticks = 4;
            s.arming.slow_m_per_s = 0.02;
        })
        .idle();
        bench.ticks(3);
        bench.device.sensed.status = SensorStatus::Failed;
        bench.tick();
        bench.device.sensed.status = SensorStatus::Good;
        bench.device.sensed.position_m.x += jumped_m;
        bench.ticks(5);
        assert!(!bench.ask(Ask::Clear).refused);
        bench.ask(Ask::TestPassed);
        bench.arm()
    };
    assert_eq!(ticks_to_arm(0.05), ticks_to_arm(0.0));
}
