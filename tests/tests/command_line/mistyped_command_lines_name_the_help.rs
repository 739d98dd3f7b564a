//! Command lines that clap refuses give exit code 2 and name the wrong word and the help.

use palpate_tests::palpate_command::{Desk, palpate};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

#[test]
fn a_mistyped_command_line_gets_one_line_that_names_the_help() {
    let desk = Desk::default();
    for (arguments, says) in [
        (["pres", ""].as_slice(), "'press'"),
        (&["press", "--scen", "block"], "'--scene'"),
        (&["pack", "--nodes", "many"], "--nodes"),
        (&["press", "--out", ""], "--out"),
        (&["far-field", "--quick"], "results/far-field.md"),
        (&["score", "marks.csv"], "host-sim/lab/src/score"),
    ] {
        let outcome = palpate(SCRATCH, desk.folder(), arguments);
        assert_eq!(outcome.code, Some(2), "{arguments:?}: {outcome:?}");
        assert!(outcome.stderr.contains(says) && outcome.stderr.contains("--help"), "{arguments:?}: {outcome:?}");
        assert!(
            outcome.stderr.lines().count() == 1 && outcome.stdout.is_empty() && desk.listing().is_empty(),
            "{arguments:?}: {outcome:?}"
        );
    }
}
