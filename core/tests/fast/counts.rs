//! Work that counts hide from the account, and the price of a rise of the force.

use std::collections::VecDeque;

use palpate::Vector3;
use palpate::haptic::account::{AccountSettings, EnergyAccount};
use palpate::haptic::device::DeviceSpec;

use crate::bench::{Bench, stylus};
use crate::energy::Port;

/// The oracle moves the true probe anywhere within half a count of the readings, in double
/// precision, and adds up the work that the forces really did.
#[test]
#[expect(clippy::disallowed_types, reason = "the oracle is in double precision")]
fn no_motion_behind_the_readings_gets_more_than_was_charged() {
    let q = 50e-6_f64;
    for (seed, delay) in [(1_u64, 0_u8), (2, 1), (3, 4), (4, 7)] {
        for sharp in [0.0, 1.0] {
            let mut port = Port::new(delay, 0.0, q as f32);
            let mut random = seed;
            let mut draw = || {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (random >> 40) as f64 / f64::from(1 << 24)
            };
            let mut sent = VecDeque::from(vec![[0.0_f64; 3]; usize::from(delay) + 1]);
            let (mut read, mut hides, mut work_j, mut most_j) = ([0_i32; 3], [0.0_f64; 3], 0.0, 0.0_f64);
            for tick in 0..4_000 {
                let acting_n = sent[0];
                let mut way_m = [0.0; 3];
                for axis in 0..3 {
                    let steps = if draw() < 0.3 { (draw() * 5.0) as i32 - 2 } else { 0 };
                    read[axis] += steps;
                    way_m[axis] = (f64::from(steps) * q) as f32;
                    // the force that acts in the next tick; a sharp probe moves against its change
                    let grows = sent.get(1).map_or(0.0, |next_n| next_n[axis] - acting_n[axis]);
                    let hidden = if sharp > 0.0 { -0.5 * q * grows.signum() } else { (draw() - 0.5) * q };
                    work_j += acting_n[axis] * (f64::from(steps) * q + hidden - hides[axis]);
                    hides[axis] = hidden;
                }
                _ = port.moves(way_m); // a fault, because nobody limits these forces
                let charged_j = f64::from(port.account.energy().given_j);
                assert!(work_j <= charged_j + 1e-6, "seed {seed}, delay {delay}, tick {tick}: {work_j} J, {charged_j} charged");
                most_j = most_j.max(work_j / charged_j.max(1e-3));
                let force_n = [0; 3].map(|_| if draw() < 0.5 { 4.0 * draw() - 2.0 } else { 0.0 });
                port.account.sent(Vector3::from(force_n.map(|n| n as f32)));
                sent.pop_front();
                sent.push_back(force_n.map(|n| f64::from(n as f32)));
            }
        }
    }
}

#[test]
fn a_rise_pays_for_a_count_along_each_axis_and_a_fall_for_nothing() {
    let q = 50e-6;
    let mut port = Port::new(1, 0.0, q);
    let mut costs = |force_n: [f32; 3]| {
        let before_j = port.account.energy().given_j;
        port.account.sent(force_n.into());
        (port.account.energy().given_j - before_j) / q
    };
    for (force_n, rise_n) in
        [([1.0, 0.0, 2.0], 3.0), ([0.5, -0.5, 2.0], 0.5), ([0.0, 0.5, 2.5], 1.0), ([0.0; 3], 0.0), ([0.0, 0.0, 1.0], 1.0)]
    {
        assert!((costs(force_n) - rise_n).abs() < 1e-4, "{force_n:?}");
    }
    // a force that would rise waits until it is paid for, and one that stays costs nothing more
    let device = DeviceSpec { count_m: q, delay_ticks: 0, mass_kg: 5.0, ..stylus() };
    let settings = AccountSettings { acceleration_m_per_s2: 0.0, handle_share: 0.0, ..AccountSettings::DEFAULT };
    let mut port = Port::with(device, settings);
    (0..3).for_each(|_| _ = port.step(0.0, 0.0));
    let balance_j = port.account.energy().balance_j;
    let first_n = port.pays([0.0, 0.0, 3.0], 0.0).z;
    // a count for the rise, and one that the probe may move unseen in the tick
    assert!((first_n * 2.0 * q / balance_j - 1.0).abs() < 1e-3, "{first_n} N for {balance_j} J");
}

#[test]
fn a_rise_is_paid_for_beside_the_forces_on_their_way() {
    let q = 50e-6;
    let device = DeviceSpec { count_m: q, delay_ticks: 4, mass_kg: 5.0, ..stylus() };
    // without an acceleration the window is one tick, and each force is paid for over a count
    let settings =
        AccountSettings { allowance_j: 7.0 * q, acceleration_m_per_s2: 0.0, handle_share: 0.0, ..AccountSettings::DEFAULT };
    let mut port = Port::with(device, settings);
    (0..1_000).for_each(|_| _ = port.step(0.0, 0.0));
    (0..4).for_each(|_| _ = port.step(0.0, 2.0));
    let left_j = port.moves([0.0; 3]).unwrap().balance_j - 4.0 * 2.0 * q;
    // 1 N of rise, and 3 N in its own tick
    let right_n = 3.0 * left_j / (q + 3.0 * q);
    let found_n = port.pays([0.0, 0.0, 3.0], 0.0).z;
    assert!(right_n > 0.1 && (found_n / right_n - 1.0).abs() < 1e-3, "{found_n} N, not {right_n} N");
}

/// A handle that a machine shakes across several counts, on a stiff wall: the readings hide where
/// it turns round. What it is given in a second stays below the lasting part of the bound.
#[test]
fn a_handle_that_is_shaken_across_counts_is_given_no_more_than_the_lasting_power() {
    let device = DeviceSpec { count_m: 55e-6, delay_ticks: 1, max_force_n: 3.0, stiffness_ceiling_n_per_m: 700.0, ..stylus() };
    let lasting_w = EnergyAccount::bound(&AccountSettings::DEFAULT, &device, 1e-3, 0).lasting_w;
    let given_w = |hz: f32, swing_m: f32, base_m: f32| {
        let mut bench = Bench::with(670.0, device, |_| ()).active();
        let (mut at_m, mut sent_n, mut given_j) = (10e-3, [0.0; 2], 0.0);
        for n in 0..9_000_u16 {
            let turns = hz * 1e-3 * f32::from(n);
            let next_m = base_m + swing_m * libm::sinf(core::f32::consts::TAU * (turns - libm::floorf(turns)));
            let next_m = if n < 1_000 { 10e-3 + (base_m - 10e-3) * 1e-3 * f32::from(n) } else { next_m };
            if n > 5_000 {
                given_j += sent_n[0] * (next_m - at_m);
            }
            at_m = next_m;
            let count_m = device.count_m;
            let applied_n = bench.at((libm::floorf(at_m / count_m) + 0.5) * count_m).applied_n.z;
            sent_n = [sent_n[1], applied_n];
        }
        given_j / 4.0
    };
    let mut most_w = 0.0_f32;
    for (hz, swing_m) in [(15.0, 290e-6), (67.0, 290e-6), (67.0, 110e-6), (101.0, 296e-6), (135.0, 270e-6), (215.0, 60e-6)] {
        for n in 0..4_u8 {
            let found_w = given_w(hz, swing_m, -2e-3 - 0.43e-3 * f32::from(n));
            assert!(found_w < lasting_w, "{hz} Hz, {swing_m} m: {found_w} W of {lasting_w}");
            most_w = most_w.max(found_w);
        }
    }
    assert!(most_w > 0.3 * lasting_w, "a motion that gets nothing would show nothing: {most_w} W");
}
