//! A debt of the account, and what pays it: energy that the hand gave in the same contact.

use palpate::Vector3;
use palpate::haptic::account::{AccountSettings, EnergyAccount};
use palpate::haptic::device::DeviceSpec;
use palpate::haptic::seen::Monitor;

use crate::bench::{Bench, stylus};
use crate::energy::Port;

/// A hand gives 1 mJ in a contact, of which the tissue can return 50 uJ; the ceiling withholds the
/// rest. After `still_ticks` the hand takes 0.5 mJ, which leaves a debt.
fn in_debt(still_ticks: u16) -> Port {
    let mut port = Port::new(0, 0.0, 0.0);
    port.step(0.0, 1.0);
    port.step(-1e-3, 0.0);
    port.pays([0.0, 0.0, 0.1], 1e-3);
    for _ in 0..still_ticks {
        port.step(0.0, 0.0);
    }
    port.account.sent(Vector3::z());
    port.step(0.5e-3, 0.0);
    port
}

#[test]
fn a_debt_is_paid_by_what_the_hand_gave_in_the_same_contact_and_nothing_beyond() {
    let mut port = in_debt(0);
    assert!(port.account.energy().balance_j < -0.42e-3, "{:?}", port.account.energy());
    let paid = (0..200).map(|_| port.step(0.0, 0.0).balance_j).collect::<Vec<_>>();
    let first = paid.iter().position(|j| *j >= 0.0).unwrap();
    assert!((50..200).contains(&first), "paid within 0.2 s, but not at once: tick {first}");
    let refill_j = 200.0 * 1e-3 * AccountSettings::DEFAULT.refill_w;
    assert!(paid.iter().all(|j| *j <= refill_j), "no more than the debt: {paid:?}");
}

#[test]
fn what_a_contact_withheld_fades_and_pays_no_debt_a_second_later() {
    let mut port = in_debt(1000);
    let owes_j = (0..200).map(|_| port.step(0.0, 0.0).balance_j).last().unwrap();
    assert!(owes_j < -0.4e-3, "{owes_j}");
}

#[test]
fn the_end_of_a_contact_pays_its_debt_and_clearing_a_fault_pays_nothing() {
    let ended = |clears: bool| {
        let mut port = in_debt(0);
        if clears {
            Monitor::reset(&mut port.account);
        }
        port.touched = false;
        (0..40).map(|_| port.step(0.0, 0.0).balance_j).last().unwrap()
    };
    assert!((0.0..2e-6).contains(&ended(false)), "the debt and no more: {}", ended(false));
    assert!(ended(true) < -0.4e-3, "{}", ended(true));
    // the next contact finds nothing of the last one
    let mut port = in_debt(0);
    port.touched = false;
    for _ in 0..40 {
        port.step(0.0, 0.0);
    }
    port.touched = true;
    port.step(0.0, 1.0);
    port.step(0.5e-3, 0.0);
    let owes_j = (0..200).map(|_| port.step(0.0, 0.0).balance_j).last().unwrap();
    assert!(owes_j < -0.4e-3, "{owes_j}");
}

/// A handle that a machine shakes across several counts, on a stiff wall: the readings hide where it
/// turns round. What it is given in a second stays below the lasting part of the bound.
#[test]
fn a_handle_that_is_shaken_across_counts_is_given_no_more_than_the_lasting_power() {
    let device = DeviceSpec { count_m: 55e-6, delay_ticks: 1, max_force_n: 3.0, stiffness_ceiling_n_per_m: 700.0, ..stylus() };
    let lasting_w = EnergyAccount::bound(&AccountSettings::DEFAULT, &device, 1e-3).lasting_w;
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
