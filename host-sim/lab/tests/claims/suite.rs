//! The suite of scenes: where the law suffices, and where a patch alone holds the scene.

use palpate_lab::suite::{FIRST_NODES, SCENES, SuiteRow, run};

/// Rows of every method on the scene of this name.
fn rows(name: &str) -> Vec<SuiteRow> {
    let scene = SCENES.iter().find(|scene| scene.name == name).unwrap();
    run(scene, FIRST_NODES).unwrap()
}

/// Larger error of each method [%], without what cannot hold the scene.
fn errors(rows: &[SuiteRow]) -> impl Iterator<Item = (&SuiteRow, f64)> {
    rows.iter().filter_map(|row| Some((row, row.worst_pct()?)))
}

#[test]
fn a_plain_block_needs_no_nodes() {
    let rows = rows("plain block");
    let (law, pct) = errors(&rows).find(|(row, _)| row.is_law()).unwrap();
    assert!(pct < 2.0, "{law:?}");
    let better = errors(&rows).find(|(row, other)| !row.is_law() && *other < pct);
    assert!(better.is_none(), "the law's error is the smallest: {better:?}");
}

#[test]
fn what_remembers_where_it_was_pressed_needs_a_patch() {
    let rows = rows("relax, slide, return");
    for (row, pct) in errors(&rows) {
        assert_eq!(pct < 5.0, row.is_patch(), "{row:?}");
    }
    assert_eq!(errors(&rows).filter(|(row, _)| row.is_patch()).count(), 2);
}

#[test]
fn the_stored_table_is_what_the_methods_give() {
    let stored = include_str!("../../suite/results/rows.csv");
    let mut found = 0;
    for row in rows("region changed while pressed").iter().filter(|row| row.held_pct.is_some()) {
        let begins = format!("{},{},", row.scene, row.method);
        let line = stored.lines().find(|line| line.starts_with(&begins)).unwrap_or_else(|| panic!("{begins} is not stored"));
        let held_pct: f64 = line.split(',').nth(5).unwrap().parse().unwrap();
        let gap = row.held_pct.unwrap() / held_pct - 1.0;
        assert!(gap.abs() < 1e-3, "{row:?}, stored: {line}");
        found += 1;
    }
    assert!(found > 8, "{found} methods");
}
