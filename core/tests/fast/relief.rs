//! The force after saturation or created energy, until the contact is over.

use palpate::haptic::cycle::Settings;
use palpate::haptic::device::DeviceSpec;
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Vector3};

use crate::bench::{Bench, CLEAR_M, pushing, set, stylus};

#[test]
fn a_force_at_its_limit_is_relieved_to_a_half_and_comes_back_with_the_next_contact() {
    let mut bench = Bench::new(400.0).active();
    bench.move_to(-8e-3, 0.05);
    let at_limit = bench.tick();
    assert!((at_limit.applied_n.z - 3.0).abs() < 1e-3 && set(&at_limit, ClampFlags::FORCE), "{}", at_limit.applied_n);
    let degraded = (0..300).find(|_| bench.tick().mode == Mode::Degraded);
    assert!(degraded.is_some_and(|ticks| ticks < 201), "{degraded:?}");
    let mut last_n = bench.tick().applied_n.z;
    assert!(last_n > 2.98, "{last_n}");
    for _ in 0..600 {
        let record = bench.tick();
        assert!(record.applied_n.z <= last_n, "{} after {last_n}", record.applied_n.z);
        assert!(last_n - record.applied_n.z < 3.1e-3 + 1e-5, "evenly, a thousandth per tick");
        last_n = record.applied_n.z;
    }
    assert!((last_n - 1.5).abs() < 1e-3, "{last_n}");
    // a smaller force does not restore the gain, which stays reduced for the whole contact
    bench.move_to(-2e-3, 0.05);
    let record = bench.ticks(300);
    assert!((record.applied_n.z - 0.4).abs() < 1e-3 && record.mode == Mode::Degraded, "{}", record.applied_n);
    assert!(set(&record, ClampFlags::GAIN));
    bench.move_to(CLEAR_M, 0.05);
    assert_eq!(bench.tick().mode, Mode::Active);
    let record = bench.press_n(1.0);
    assert!((record.applied_n.z - 1.0).abs() < 1e-3 && !set(&record, ClampFlags::GAIN));
}

#[test]
fn relief_begins_after_two_hundred_ticks_and_not_below_the_limit() {
    let mut bench = Bench::new(400.0).active();
    bench.wall.answer = Some(pushing(5e-3, 2.9));
    let record = bench.ticks(500);
    assert_eq!((record.mode, set(&record, ClampFlags::GAIN)), (Mode::Active, false));
    bench.wall.answer = Some(pushing(5e-3, 3.1));
    assert!(!set(&bench.ticks(200), ClampFlags::GAIN));
    assert!(set(&bench.tick(), ClampFlags::GAIN), "from the next tick on");
}

/// Runs a contact at 1 N that gives the hand this much more energy than it took [J].
fn contact(bench: &mut Bench, given_j: f32) {
    let step_m = 0.1e-3_f32.copysign(given_j);
    bench.wall.answer = Some(pushing(1e-3, 1.0));
    bench.ticks(5);
    let start_m = bench.device.sensed.position_m.z;
    let gain = bench.tick().applied_n.z;
    assert!(gain > 0.1, "{gain}");
    for _ in 0..(given_j.abs() / (gain * step_m.abs())) as usize {
        bench.at(bench.device.sensed.position_m.z + step_m);
    }
    bench.wall.answer = Some(palpate::Output::NONE);
    bench.ticks(5);
    bench.move_to(start_m, 0.1);
}

#[test]
fn a_probe_that_leaves_is_pushed_by_no_more_than_it_brought() {
    let mut bench = Bench::new(400.0).active();
    bench.wall.answer = Some(pushing(1e-3, 1.0));
    assert!((bench.ticks(5).applied_n.z - 1.0).abs() < 1e-5, "at rest, with nothing taken");
    let start_m = bench.device.sensed.position_m.z;
    let way = |bench: &mut Bench, step_m: f32| {
        let mut work_j = 0.0;
        for _ in 0..10 {
            let force_n = bench.at(bench.device.sensed.position_m.z + step_m).applied_n.z;
            work_j += force_n * step_m;
        }
        work_j
    };
    assert_eq!(way(&mut bench, 0.1e-3), 0.0, "nothing was taken");
    assert!(set(&bench.at(bench.device.sensed.position_m.z + 0.1e-3), ClampFlags::ENERGY), "and the record says so");
    // 1 N over 1 mm, and damping
    bench.move_to(start_m + 1e-3, 0.1);
    let taken_j = -way(&mut bench, -0.1e-3);
    assert!(!set(&bench.at(bench.device.sensed.position_m.z), ClampFlags::ENERGY), "a force that takes is whole");
    assert!((0.8e-3..1.5e-3).contains(&taken_j), "{taken_j}");
    let given_j = way(&mut bench, 0.1e-3) + way(&mut bench, 0.1e-3);
    assert!((0.3 * taken_j..taken_j).contains(&given_j), "{given_j} of {taken_j}");
    assert_eq!(way(&mut bench, 0.1e-3), 0.0, "all is given back");
    assert!((bench.device.sensed.position_m.z - start_m - 3e-3).abs() < 1e-6);
}

#[test]
fn friction_outlasts_the_push_on_a_probe_that_slides_out() {
    let mut bench = Bench::new(400.0).active();
    let force_n = Vector3::new(-0.4, 0.0, 1.0);
    bench.wall.answer = Some(palpate::Output { force_n, grip_n: 0.4, ..pushing(1e-3, 1.0) });
    bench.ticks(5);
    let slid = (0..40).map(|_| {
        bench.device.sensed.position_m.x += 0.05e-3;
        bench.at(bench.device.sensed.position_m.z + 0.1e-3)
    });
    let slid = slid.last().expect("ticks");
    // friction takes 0.4 N times half of the distance over which the push gives
    assert!((slid.applied_n - Vector3::new(-0.4, 0.0, 0.2)).norm() < 0.03, "{slid:?}");
    assert!(set(&slid, ClampFlags::ENERGY));
}

#[test]
fn created_energy_fades_the_force_and_degrades_until_a_good_contact() {
    // without the allowance no force would reach the alarm
    let allow = |settings: &mut Settings| settings.passivity.allowance_j = 0.1;
    let mut bench = Bench::with(400.0, stylus(), allow).active();
    contact(&mut bench, 0.9e-3);
    let record = bench.ticks(25);
    assert!(record.energy.total_created_j > 0.5e-3, "{:?}", record.energy);
    assert_eq!(record.mode, Mode::Degraded, "free space, and the next contact is to be half as strong");
    assert!(set(&record, ClampFlags::ENERGY));
    bench.wall.answer = Some(pushing(1e-3, 1.0));
    let force_n = bench.ticks(10).applied_n;
    assert!((force_n - Vector3::new(0.0, 0.0, 0.5)).norm() < 1e-5, "{force_n}");
    bench.wall.answer = Some(palpate::Output::NONE);
    bench.ticks(25);
    contact(&mut bench, -0.3e-3);
    let record = bench.ticks(25);
    assert_eq!((record.mode, set(&record, ClampFlags::ENERGY)), (Mode::Active, false));
}

#[test]
fn a_strong_force_without_any_motion_of_the_encoder_is_gone_after_six_seconds() {
    let mut bench = Bench::new(400.0).active();
    let still_n = bench.press_n(2.0).applied_n.z;
    let record = bench.ticks(4_800);
    assert_eq!((record.applied_n.z, record.mode), (still_n, Mode::Active));
    let mut last_n = still_n;
    for _ in 0..1_200 {
        let record = bench.tick();
        assert!(record.applied_n.z <= last_n);
        last_n = record.applied_n.z;
    }
    assert_eq!((last_n, bench.cycle.mode()), (0.0, Mode::Degraded));
    // motion in contact does not restore the force, a new contact does
    bench.move_to(-4e-3, 0.05);
    assert_eq!(bench.tick().applied_n.z, 0.0);
    bench.move_to(CLEAR_M, 0.05);
    assert_eq!(bench.cycle.mode(), Mode::Active);
    assert!((bench.press_n(1.0).applied_n.z - 1.0).abs() < 1e-3);
}

#[test]
fn a_force_that_fades_because_it_swings_does_not_rise_again() {
    let mut bench = Bench::new(400.0).active();
    let (mut last_n, mut fades) = (f32::INFINITY, false);
    for n in 0..400_u16 {
        let force_n = if n / 9 % 2 == 0 { 0.3 } else { 1.2 };
        bench.wall.answer = Some(pushing(1e-3, force_n));
        let record = bench.tick();
        fades |= set(&record, ClampFlags::GAIN);
        assert!(!fades || record.applied_n.z <= last_n * (1.0 + 1e-6), "{} after {last_n} in tick {n}", record.applied_n.z);
        last_n = record.applied_n.z;
    }
    assert!(fades && last_n == 0.0, "{last_n}");
}

#[test]
fn a_hand_that_comes_to_rest_with_its_contact_spent_feels_the_force_again_at_once() {
    let count_m = 55e-6;
    let mut bench = Bench::with(400.0, DeviceSpec { count_m, ..stylus() }, |_| ()).active();
    bench.wall.answer = Some(pushing(1e-3, 1.0));
    bench.ticks(5);
    for _ in 0..10 {
        bench.at(bench.device.sensed.position_m.z + count_m);
    }
    assert_eq!(bench.tick().applied_n.z, 0.0, "nothing was taken");
    let ticks = (1..1000).find(|_| bench.tick().applied_n.z > 0.0);
    assert!(ticks.is_some_and(|ticks| ticks < 30), "{ticks:?}");
    assert!((bench.ticks(5).applied_n.z - 1.0).abs() < 1e-2);
}
