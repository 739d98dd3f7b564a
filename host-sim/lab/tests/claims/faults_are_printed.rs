//! `palpate faults`: the verdict comes first and last, and rows that passed are printed on request.

use crate::palpate_command::{Desk, palpate};

#[test]
fn rows_that_passed_are_printed_when_they_are_asked_for() {
    let desk = Desk::default();
    let [short, all] = [&["faults", "--runs", "100"][..], &["faults", "--runs", "100", "--all"]].map(|arguments| {
        let outcome = palpate(env!("CARGO_TARGET_TMPDIR"), desk.folder(), arguments);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        outcome.stdout
    });
    let kinds = std::fs::read_to_string(desk.folder().join("out/faults/faults.csv")).unwrap().lines().count() - 1;
    assert!(kinds > 70 && short.lines().count() < 20 && all.lines().count() > kinds, "{short}");
    assert!(short.contains("--all") && short.contains("a numbered fault, zero force"), "{short}");
    let (first, last) = (short.lines().next().unwrap(), short.lines().next_back().unwrap());
    assert!(first == last && first.starts_with("ok: "), "{short}");
}
