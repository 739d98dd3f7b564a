//! `palpate`, `palpate-full`, the Python package, the tests and the evidence's workspace share one
//! build of every crate of others, and `palpate` needs few crates.

use std::collections::BTreeSet;
use std::process::Command;

use palpate_tests::palpate_command::repository;

/// Largest number of external crates that a first build may compile.
const MOST_CRATES: usize = 90;

/// Crates that a build of these packages compiles, each with version and features.
fn crates(arguments: &[&str]) -> BTreeSet<String> {
    crates_of("", arguments)
}

/// Crates that a build in this folder of the repository compiles.
fn crates_of(workspace: &str, arguments: &[&str]) -> BTreeSet<String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let mut tree = Command::new(cargo);
    tree.args(["tree", "--locked", "--offline", "--prefix", "none", "--format", "{p} {f}"]).args(arguments);
    let output = tree.current_dir(repository().join(workspace)).output().expect("cargo runs this test, so it starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
}

const PALPATE: [&str; 4] = ["--package", "palpate-sim", "--edges", "normal,build"];

fn is_external(line: &str) -> bool {
    !line.starts_with("palpate")
}

/// A different feature anywhere below `core` would cause all crates to be compiled again: for the
/// `palpate-full` that the tests run, when a user first needs that program, and for the Python
/// package.
#[test]
fn no_crate_is_built_twice_for_a_feature() {
    let palpate = crates(&PALPATE);
    let full = crates(&[&PALPATE[..], &["--features", "full"]].concat());
    let python = crates(&["--package", "palpate-python", "--edges", "normal,build"]);
    let tests = crates(&["--workspace", "--edges", "normal,build,dev"]);
    let lab = crates_of("host-sim/lab", &["--edges", "normal,build,dev"]);
    // the lab builds the crates of the repository anew
    let lab = lab.into_iter().filter(|line| is_external(line)).collect();
    let alone = |line: &&String| !line.starts_with("palpate-sim ");
    let pairs = [
        (&palpate, &full, "palpate, palpate-full"),
        (&full, &tests, "palpate-full, the tests"),
        (&python, &tests, "the Python package, the tests"),
        (&lab, &full, "the evidence's workspace, palpate-full"),
    ];
    for (smaller, larger, names) in pairs {
        let twice: Vec<_> = smaller.difference(larger).filter(alone).collect();
        assert!(
            twice.is_empty(),
            "with other features in {names}: {twice:?}; name them in host-sim/Cargo.toml, host-sim/lab/Cargo.toml or host-sim/bindings/python/Cargo.toml"
        );
    }
}

#[test]
fn the_first_build_has_few_crates() {
    let palpate = crates(&PALPATE);
    let names: BTreeSet<_> =
        palpate.iter().filter(|line| is_external(line)).map(|line| line.split(' ').take(2).collect::<Vec<_>>()).collect();
    println!("{} external crates", names.len());
    assert!(names.len() > 50 && names.len() <= MOST_CRATES, "{}: {names:?}", names.len());
}
