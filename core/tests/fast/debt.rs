//! A debt of the account, and what pays it: energy that the hand gave in the same contact.

use palpate::Vector3;
use palpate::haptic::account::AccountSettings;
use palpate::haptic::seen::Monitor;

use crate::energy::Port;

/// A hand gives 1 mJ in a contact, of which the tissue can return 50 uJ; the ceiling withholds the
/// rest. After `still_ticks` the hand takes 0.5 mJ, which leaves a debt.
fn in_debt(still_ticks: u16) -> Port {
    let mut port = Port::light(0, 0.0);
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
fn the_end_of_a_contact_pays_its_debt_and_a_fault_ends_the_contact() {
    let ended = |faulted: bool| {
        let mut port = in_debt(0);
        if faulted {
            Monitor::reset(&mut port.account);
            assert_eq!(port.account.energy().balance_j, 0.0, "the debt and no more");
        }
        port.touched = false;
        (0..40).map(|_| port.step(0.0, 0.0).balance_j).last().unwrap()
    };
    assert!((0.0..2e-6).contains(&ended(false)), "the debt and no more: {}", ended(false));
    assert!((0.0..2e-6).contains(&ended(true)), "{}", ended(true));
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
