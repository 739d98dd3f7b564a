//! Work in ticks without a reading: missing or held ones, missed periods, faults.

use std::collections::VecDeque;

use palpate::Vector3;
use palpate::haptic::account::AccountSettings;
use palpate::haptic::cycle::{Ask, Command};
use palpate::haptic::device::DeviceSpec;
use palpate::haptic::mode::Mode;

use crate::bench::{Bench, stylus};
use crate::energy::Port;

/// The sharpest way of that stylus beyond its pace in a tick, by a hand and by its motors [m].
const SHARP_M: f32 = (200.0 + 3.3 / 0.045) * 1e-6;

/// Every few readings one or two are missing, or a period is missed. The oracle draws the probe's
/// acceleration, up to the sharpest, in every tick, against the change of the force where `spites`.
#[test]
#[expect(clippy::disallowed_types, reason = "the oracle is in double precision")]
fn no_motion_between_missing_readings_gets_more_than_was_charged() {
    // rounded, the sharpest itself could look like a jump
    let sharp_m = 0.999 * f64::from(SHARP_M);
    for (seed, delay) in [(1_u64, 0_u8), (2, 1), (3, 4)] {
        for (spites, misses) in [(false, false), (true, false), (true, true)] {
            let mut port = Port::new(delay, 0.0, 0.0);
            let mut random = seed;
            let mut draw = || {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (random >> 40) as f64 / f64::from(1 << 24)
            };
            let mut sent = VecDeque::from(vec![0.0_f64; usize::from(delay) + 1]);
            let (mut at_m, mut speed_m, mut read_m, mut unread) = (0.0_f64, 0.0_f64, 0.0_f64, 0);
            let (mut work_j, mut forces) = (0.0, 0.0_f64);
            for tick in 0..20_000 {
                let acting_n = sent[0];
                let grows = sent.get(1).map_or(0.0, |next_n| next_n - acting_n);
                let sign = if spites { -grows.signum() } else { 2.0 * draw() - 1.0 };
                let home = at_m.abs() + 10.0 * speed_m.abs() > 10e-3;
                let turn_m = if home { -sharp_m * (at_m + 5.0 * speed_m).signum() } else { sharp_m * sign };
                at_m += speed_m + 0.5 * turn_m;
                work_j += acting_n * (speed_m + 0.5 * turn_m);
                speed_m += turn_m;
                let missing = unread < 2 && draw() < 0.4;
                unread = if missing { unread + 1 } else { 0 };
                let next_n = if draw() < 0.5 { 4.0 * draw() - 2.0 } else { forces };
                if missing && misses {
                    // the period passes without a tick, and the device holds its force
                    sent.pop_front();
                    sent.push_back(forces);
                    port.late = true;
                    unread = 2;
                    continue;
                }
                port.held = missing;
                if !missing {
                    port.at_m.z = 0.0;
                    read_m = at_m;
                }
                _ = port.moves([0.0, 0.0, read_m as f32 - port.at_m.z]);
                port.late = false;
                let charged_j = f64::from(port.account.energy().given_j);
                if !missing {
                    // the sum is rounded in every tick
                    let most_j = charged_j + 1e-6 + 3e-8 * f64::from(tick);
                    assert!(work_j <= most_j, "seed {seed}, {delay}, tick {tick}: {work_j} J, {charged_j} charged");
                }
                forces = f64::from(next_n as f32);
                port.account.sent(Vector3::z() * forces as f32);
                sent.pop_front();
                sent.push_back(forces);
            }
        }
    }
}

#[test]
fn the_error_of_a_position_grows_with_the_ticks_since_and_between_the_last_readings() {
    for count_m in [0.0, 50e-6] {
        for (between, since) in [(1_u8, 1_u8), (1, 2), (1, 4), (2, 1), (3, 2)] {
            let mut port = Port::new(0, 0.0, count_m);
            let mut hold = |held: bool, force_n: f32| {
                port.held = held;
                port.step(0.0, force_n).given_j
            };
            hold(false, 0.0);
            hold(false, 1.0);
            (1..between).for_each(|_| _ = hold(true, 1.0));
            hold(false, 1.0);
            (1..since).for_each(|_| _ = hold(true, 1.0));
            // the force ends where nothing was read
            let before_j = hold(true, 0.0);
            let paid_j = hold(false, 0.0) - before_j;
            let (h, g) = (f32::from(since), f32::from(between));
            let most_m = (h + 0.5) * count_m + 0.5 * h * (h + g) * SHARP_M;
            assert!((paid_j / most_m - 1.0).abs() < 1e-2, "{since} after {between}: {paid_j} J for {most_m} m");
        }
    }
}

#[test]
fn the_loop_charges_a_reading_that_is_missing_and_a_period_that_is_missed() {
    let step_m = 50e-6;
    for late in [false, true] {
        let mut bench = Bench::with(400.0, DeviceSpec { delay_ticks: 1, ..stylus() }, |_| ()).active();
        bench.press_n(1.0);
        let mut last = [bench.tick(); 2];
        for _ in 0..5 {
            last = [last[1], bench.at(bench.device.sensed.position_m.z + step_m)];
        }
        let [older_n, newer_n] = last.map(|record| record.applied_n.z);
        let record = if late {
            bench.device.sensed.position_m.z += 2.0 * step_m;
            bench.late(1)
        } else {
            bench.repeat(Command::HEARD)
        };
        let charged_j = record.energy.given_j - last[1].energy.given_j;
        let due_j = match late {
            true => (older_n + newer_n) * step_m + (newer_n - older_n).abs() * SHARP_M,
            false => older_n * step_m,
        };
        assert!((charged_j / due_j - 1.0).abs() < 0.01, "late {late}: {charged_j} J, {due_j} due");
    }
}

#[test]
fn every_missed_period_before_a_fault_is_charged() {
    let owes_j = |missed: u16| {
        let mut bench = Bench::with(400.0, DeviceSpec { delay_ticks: 1, ..stylus() }, |_| ()).active();
        let pressed_j = bench.press_n(1.0).energy.balance_j;
        let record = bench.repeat(Command { late_ticks: missed, ..Command::HEARD });
        assert!(record.fault.is_some());
        let (h, g) = (f32::from(missed) + 1.0, 1.0);
        // where the sharpest motion may have led to until the force of 1 N ended
        (pressed_j - bench.tick().energy.balance_j, 0.5 * h * (h + g) * SHARP_M)
    };
    for missed in [3, 4, 6] {
        let (owed_j, due_j) = owes_j(missed);
        // what the ceiling withheld in the contact pays a little of it
        assert!((owed_j / due_j - 1.0).abs() < 0.05, "{missed}: {owed_j} J, {due_j} due");
    }
}

/// A hand that leaves: a reading that is missing must not look like a hand at rest, whose damping
/// is gone.
#[test]
fn a_position_that_was_not_read_says_nothing_about_the_velocity() {
    let mut bench = Bench::with(400.0, DeviceSpec { delay_ticks: 1, ..stylus() }, |_| ()).active();
    let pressed_n = bench.press_n(2.0).applied_n.z;
    let step_m = 0.1e-3;
    let leaves = |bench: &mut Bench| bench.at(bench.device.sensed.position_m.z + step_m).applied_n.z;
    let mut last_n = pressed_n;
    for tick in 0..30 {
        let force_n = if tick % 7 == 6 {
            bench.device.sensed.position_m.z += step_m;
            bench.repeat(Command::HEARD).applied_n.z
        } else {
            leaves(&mut bench)
        };
        assert!(force_n <= last_n, "tick {tick}: {last_n} N rises to {force_n} N");
        last_n = force_n;
    }
    assert!(last_n < 0.5 * pressed_n && last_n > 0.0, "{last_n} N of {pressed_n} N");
}

#[test]
fn a_jump_of_the_sensor_is_charged_its_largest_error_and_credits_nothing() {
    for (axis, jump_m) in [(0, 4e-3_f32), (1, -4e-3), (2, -4e-3), (2, 4e-3)] {
        let along = |length: f32| {
            let mut vector = Vector3::zeros();
            vector[axis] = length;
            vector
        };
        let mut port = Port::new(0, 0.0, 0.0);
        let pace_m = -0.02e-3;
        for _ in 0..10 {
            port.moves(along(pace_m).into()).unwrap();
            port.account.sent(along(1.0));
        }
        let mut paid_m = |way_m: f32| {
            let before_j = port.account.energy().given_j;
            _ = port.moves(along(way_m).into());
            port.account.sent(along(1.0));
            port.account.energy().given_j - before_j
        };
        for (way_m, due_m) in [
            // the sensor jumps and stays there
            (jump_m, pace_m),
            (pace_m, pace_m + 3.0 * SHARP_M),
            (pace_m, pace_m),
            // it jumps and comes back
            (-jump_m, pace_m),
            (jump_m + 2.0 * pace_m, pace_m),
            (pace_m + 0.9 * SHARP_M, pace_m + 0.9 * SHARP_M),
            // two jumps in a row find a pace that is older
            (pace_m + jump_m, pace_m + 0.9 * SHARP_M),
            (pace_m, pace_m + 3.9 * SHARP_M),
            (pace_m + jump_m, pace_m + 0.9 * SHARP_M),
            (pace_m, pace_m + 7.9 * SHARP_M),
        ] {
            let found_m = paid_m(way_m);
            assert!((found_m - due_m).abs() < 1e-6, "axis {axis}, {jump_m} m: moved by {way_m} m, {found_m} J paid, {due_m} due");
        }
    }
}

#[test]
fn a_force_on_its_way_acts_and_none_does_once_the_device_is_released() {
    for (delay, lag_s, ticks) in [(0, 0.0, 1), (2, 0.0, 3), (1, 5e-3, 17)] {
        let sent = || {
            let mut port = Port::new(delay, lag_s, 0.0);
            assert!(!port.account.acts(), "nothing was sent");
            port.step(0.0, 1.0);
            port
        };
        let mut port = sent();
        let acted = (0..100).take_while(|_| {
            let acts = port.account.acts();
            port.step(0.0, 0.0);
            acts
        });
        assert_eq!(acted.count(), ticks, "{delay} ticks, {lag_s} s");
        let mut port = sent();
        port.account.released();
        assert!(!port.account.acts(), "released");
    }
    // the loop: a hand that is faster than any under a force, while the last one is on its way
    let mut bench = Bench::with(400.0, DeviceSpec { delay_ticks: 7, ..stylus() }, |_| ()).active();
    bench.press_n(0.2);
    bench.move_to(0.5e-3, 0.5);
    assert_eq!(bench.tick().applied_n, Vector3::zeros(), "outside");
    let fault = (0..3).find_map(|_| bench.at(bench.device.sensed.position_m.z + 6e-3).fault);
    assert_eq!(fault, Some(palpate::Fault::OverSpeed));
}

/// Longest displacement that a force of 10 N is paid for at rest [m], after ticks with and without
/// a reading.
fn paid_for_m(count_m: f32, reads: &[bool]) -> f32 {
    let device = DeviceSpec { delay_ticks: 0, mass_kg: 5.0, count_m, ..stylus() };
    let mut port = Port::with(device, AccountSettings::DEFAULT);
    (0..1_000).for_each(|_| _ = port.step(0.0, 0.0));
    for read in reads {
        port.held = !read;
        port.step(0.0, 0.0);
    }
    let paid_n = port.pays([0.0, 0.0, 10.0], 0.0).z;
    port.account.energy().balance_j / paid_n
}

#[test]
fn from_the_second_missing_reading_on_a_force_is_paid_for_the_error_of_the_pace() {
    let sharp_m = (200.0 + 3.3 / 5.0) * 1e-6;
    let (yes, no) = (true, false);
    for count_m in [0.0, 50e-6] {
        for (reads, ticks) in [
            (&[yes][..], None),
            (&[no], None),
            (&[no, no], Some(3.0)),
            (&[no, no, no, no], Some(5.0)),
            // a pace over two ticks is older by half a tick
            (&[no, yes], None),
            (&[no, yes, no, no], Some(3.5)),
        ] {
            let astray_m = paid_for_m(count_m, reads) - paid_for_m(count_m, &[]);
            let right_m = ticks.map_or(0.0, |ticks: f32| count_m + ticks * sharp_m);
            assert!((astray_m - right_m).abs() < 2e-6, "{count_m} m, {reads:?}: {astray_m} m, not {right_m} m");
        }
    }
}

/// A hand that moves along the force in the tick in which the board finds a fault.
#[test]
fn the_tick_of_a_fault_that_the_board_finds_is_charged_by_its_reading() {
    let owes_j = |way_m: f32| {
        let mut bench = Bench::with(400.0, DeviceSpec { delay_ticks: 1, ..stylus() }, |_| ()).active();
        // tissue that can return next to nothing, and a hand that moves across its force
        bench.wall.answer = Some(crate::bench::pushing(1e-6, 1.0));
        let mut force_n = 0.0;
        for _ in 0..100 {
            bench.device.sensed.position_m.x += 10e-6;
            force_n = bench.tick().applied_n.z;
        }
        bench.device.sensed.position_m.z += way_m;
        (force_n, bench.find(palpate::Fault::SupplyLow).energy.balance_j)
    };
    let (force_n, rests_j) = owes_j(0.0);
    let (_, moved_j) = owes_j(0.2e-3);
    assert!(
        force_n > 0.2 && ((rests_j - moved_j) / (0.2e-3 * force_n) - 1.0).abs() < 0.01,
        "{force_n} N, {rests_j} and {moved_j} J"
    );
}

#[test]
fn forces_on_their_way_end_when_the_loop_is_stopped() {
    let mut bench = Bench::with(400.0, DeviceSpec { delay_ticks: 7, ..stylus() }, |_| ()).active();
    bench.press_n(1.0);
    bench.ask(Ask::Stop);
    let ended = (0..1_000).find(|_| bench.tick().mode == Mode::Idle);
    assert!(ended.is_some());
    let given_j = bench.tick().energy.given_j;
    let moves = |bench: &mut Bench| bench.at(bench.device.sensed.position_m.z + 0.1e-3).energy.given_j;
    assert!((0..7).all(|_| moves(&mut bench) == given_j), "{given_j} J");
}
