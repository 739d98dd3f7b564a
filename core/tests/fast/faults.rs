//! Whatever fails, the force is zero in the same tick, the first fault is kept, and it is cleared
//! only on request and after good poses.

use palpate::haptic::cycle::{Ask, Command};
use palpate::haptic::device::SensorStatus;
use palpate::haptic::mode::Mode;
use palpate::{Fault, Output, Vector3};

use crate::bench::{Bench, CLEAR_M, pushing, stylus};

/// A bench that is pressed with 2 N.
fn pressed() -> Bench {
    let mut bench = Bench::new(400.0).active();
    bench.press_n(2.0);
    bench
}

/// Checks that the tick of `cause` ends in `Fault` with the device released.
fn faults(fault: Fault, cause: impl Fn(&mut Bench)) {
    let mut bench = pressed();
    cause(&mut bench);
    let record = bench.tick();
    assert_eq!((record.fault, record.mode, record.applied_n), (Some(fault), Mode::Fault, Vector3::zeros()));
    assert_eq!(bench.device.drive_n, None, "{fault:?}: released in the same tick");
    assert!(!bench.cycle.in_contact());
}

#[test]
fn every_cause_releases_the_device_in_the_same_tick() {
    faults(Fault::SensorFault, |b| b.device.sensed.status = SensorStatus::Failed);
    faults(Fault::PoseNotFinite, |b| b.device.sensed.position_m.y = f32::NAN);
    faults(Fault::ForceNotFinite, |b| b.wall.answer = Some(pushing(1e-3, f32::NAN)));
    // a force that is a number, and a normal that is none: the damping is none then
    let askew = Output { normal: Vector3::repeat(f32::NAN), ..pushing(1e-3, 1.0) };
    faults(Fault::ForceNotFinite, |b| b.wall.answer = Some(askew));
    faults(Fault::Diverged, |b| b.wall.answer = Some(Output { fault: Some(Fault::Diverged), ..Output::NONE }));
    let mut bench = pressed();
    let record = bench.find(Fault::SupplyLow);
    assert_eq!((record.fault, record.applied_n, bench.device.drive_n), (Some(Fault::SupplyLow), Vector3::zeros(), None));
}

#[test]
fn the_first_fault_is_kept_and_stays_for_ever() {
    let mut bench = pressed();
    bench.find(Fault::SupplyLow);
    bench.device.sensed.position_m.x = f32::NAN;
    assert_eq!(bench.tick().fault, Some(Fault::SupplyLow), "a later one does not take its place");
    bench.device.sensed.position_m.x = 0.0;
    bench.move_to(CLEAR_M, 0.1);
    for _ in 0..1_000 {
        let record = bench.tick();
        assert_eq!((record.fault, record.mode, bench.device.drive_n), (Some(Fault::SupplyLow), Mode::Fault, None));
    }
    assert!(bench.ask(Ask::Arm).refused && bench.ask(Ask::TestPassed).refused);
}

#[test]
fn a_fault_is_cleared_after_a_hundred_good_poses_and_not_before() {
    let mut bench = pressed();
    bench.find(Fault::SupplyLow);
    for _ in 0..99 {
        assert!(bench.ask(Ask::Clear).refused);
    }
    // a bad pose restarts the count
    bench.device.sensed.status = SensorStatus::Failed;
    bench.tick();
    bench.device.sensed.status = SensorStatus::Good;
    for _ in 0..100 {
        assert!(bench.ask(Ask::Clear).refused);
    }
    let resets = bench.wall.resets;
    let record = bench.ask(Ask::Clear);
    assert_eq!((record.refused, record.mode, record.fault), (false, Mode::SelfTest, None));
    assert_eq!(bench.wall.resets, resets + 1, "the patch comes to rest");
}

/// Clears the fault and arms again, clear of the wall.
fn clear(bench: &mut Bench) {
    bench.wall.answer = None;
    bench.device.sensed.position_m.z = CLEAR_M;
    bench.ticks(101);
    assert!(!bench.ask(Ask::Clear).refused);
    bench.ask(Ask::TestPassed);
    bench.arm();
}

#[test]
fn after_a_fault_the_way_to_a_force_is_that_of_the_first_time() {
    let mut bench = pressed();
    bench.find(Fault::SupplyLow);
    clear(&mut bench);
    bench.wall.answer = Some(pushing(5e-3, 2.0));
    assert!((0..50).all(|_| bench.tick().applied_n.norm() < 0.01), "the gain rises anew");
}

#[test]
fn a_fault_forgives_the_late_ticks_and_the_energy_before_it() {
    let mut bench = Bench::with(400.0, stylus(), |s| s.arming.calm_ticks = 4).active();
    for _ in 0..4 {
        assert_eq!(bench.late(1).fault, None);
        bench.ticks(5);
    }
    bench.find(Fault::SupplyLow);
    bench.ticks(5);
    bench.ask(Ask::Clear);
    bench.ask(Ask::TestPassed);
    bench.arm();
    assert_eq!(bench.late(1).fault, None, "the first late tick after the fault");
}

#[test]
fn energy_since_before_a_fault_is_not_the_next_contacts() {
    let mut bench = pressed();
    let before = bench.tick().energy;
    assert!(before.given_j < -1e-3, "the wall holds what the hand gave: {before:?}");
    let record = bench.find(Fault::SupplyLow);
    assert_eq!(record.energy.given_j, 0.0);
    assert_eq!(record.position_m, Vector3::zeros(), "no pose is believed");
}

#[test]
fn what_the_model_asks_for_while_no_force_may_act_is_no_fault() {
    let mut bench = Bench::new(400.0).idle();
    bench.ask(Ask::Arm);
    bench.wall.answer = Some(pushing(1e-3, 1e4));
    let record = bench.ticks(100);
    assert_eq!((record.mode, record.fault, record.applied_n.norm()), (Mode::Arming, None, 0.0));
}

#[test]
fn an_implausible_force_is_borne_nine_ticks_within_the_limits() {
    let mut bench = Bench::new(400.0).active();
    bench.wall.answer = Some(pushing(1e-3, 16.6));
    for _ in 0..9 {
        let record = bench.tick();
        assert_eq!(record.fault, None);
        assert!(record.applied_n.norm() <= 3.0 + 1e-5);
    }
    assert_eq!(bench.tick().fault, Some(Fault::ForceImplausible));
}

#[test]
fn nothing_but_zero_leaves_in_modes_without_a_force() {
    let mut bench = Bench::new(400.0);
    bench.wall.answer = Some(pushing(5e-3, 2.0));
    for asked in [None, Some(Ask::Booted), Some(Ask::TestPassed), Some(Ask::Arm)] {
        let record = bench.run(Command { asked, ..Command::HEARD });
        assert_eq!((record.applied_n, bench.device.drive_n), (Vector3::zeros(), None), "{asked:?}");
    }
    assert_eq!(bench.ticks(500).applied_n, Vector3::zeros());
}
