//! Command lines that clap refuses give exit code 2 and name the wrong word and the help.

use std::process::{Command, Output};

use palpate_tests::palpate_command::{Desk, binary, palpate};

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
        (&["calibrate", "--quick"], "palpate fit"),
        (&["cut", "--radius", "16mm"], "palpate fit --board BOARD"),
        (&["plan", "--tolerance-pct", "3"], "palpate fit --smallest --board BOARD"),
        (&["reference"], "palpate fit"),
        (&["help", "cut"], "palpate fit --board BOARD"),
        (&["check", "plan"], "palpate fit --smallest --board BOARD"),
        (&["fit", "--smallest"], "--board"),
    ] {
        let outcome = palpate(SCRATCH, desk.folder(), arguments);
        assert_eq!(outcome.code, Some(2), "{arguments:?}: {outcome:?}");
        // the help of a command that is gone is the same line
        let helps = outcome.stderr.contains("see --help") || outcome.stderr.contains("is gone: ");
        assert!(outcome.stderr.contains(says) && helps, "{arguments:?}: {outcome:?}");
        assert!(
            outcome.stderr.lines().count() == 1 && outcome.stdout.is_empty() && desk.listing().is_empty(),
            "{arguments:?}: {outcome:?}"
        );
    }
}

/// Help, and what is wrong with the arguments of a study, need no build: here a build would fail.
#[test]
fn help_and_refusals_build_nothing() {
    let desk = Desk::default();
    let ran = |line: &str| -> Output {
        let mut command = Command::new(binary(SCRATCH));
        command.args(line.split(' ')).current_dir(desk.folder()).env("CARGO", "/nowhere/cargo");
        command.output().expect("palpate was just built")
    };
    for command in [
        "accept",
        "chart",
        "faults",
        "paper",
        "paper local-compression",
        "stability",
        "suite",
        "unseen",
        "fit",
        "pack",
        "emulate",
        "board arm",
    ] {
        let help = ran(&format!("{command} --help"));
        let text = String::from_utf8_lossy(&help.stdout);
        assert!(help.status.success() && text.contains(&format!("Usage: palpate {command}")), "{command}: {text}");
        assert!(help.stderr.is_empty(), "{command}: {help:?}");
    }
    for line in ["accept T9", "chart --kpa soft", "faults --runs 3", "paper volume", "stability --model --loop"] {
        let refused = ran(line);
        let why = String::from_utf8_lossy(&refused.stderr);
        assert!(refused.status.code() == Some(2) && why.lines().count() == 1 && why.contains("--help"), "{line}: {why}");
    }
    let built = ran("chart --quick");
    let why = String::from_utf8_lossy(&built.stderr);
    assert!(built.status.code() == Some(2) && why.contains("https://rustup.rs"), "{why}");
    assert!(desk.listing().is_empty());
}
