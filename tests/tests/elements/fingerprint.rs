//! Finite elements are solved again only when what they depend on has changed since every test
//! passed, and in the long form.
//!
//! After a change, when the tests have passed: `cargo test --release --package palpate-tests --test
//! elements -- --ignored rewrite_the_fingerprint`.

use std::fs;
use std::path::{Path, PathBuf};

use palpate::Fnv;
use palpate_tests::palpate_command::repository;
use palpate_tests::share::long;

/// Beginnings of the paths whose files the results depend on.
const SOURCES: [&str; 11] = [
    "host-sim/fit/src/reference",
    "host-sim/references/block.json",
    "host-sim/tissue/src/mesh",
    "host-sim/tissue/src/moving",
    "host-sim/tissue/src/probe_surface",
    "host-sim/tissue/src/scene",
    "host-sim/tissue/src/tissue",
    "tests/data/stiffening",
    "tests/tests/elements/fem_reference",
    "tests/tests/elements/stiffening_agrees",
    "tests/tests/elements/stiffening_regions",
];
/// Packages of others that solve and multiply.
const PACKAGES: [&str; 2] = ["faer", "nalgebra"];

fn golden() -> PathBuf {
    repository().join("tests/golden/finite-elements.txt")
}

/// Files at and below a path, in the order of their names.
fn files(at: &Path) -> Vec<PathBuf> {
    if at.is_file() {
        return vec![at.to_owned()];
    }
    let mut below: Vec<_> = fs::read_dir(at).unwrap().map(|entry| entry.unwrap().path()).collect();
    below.sort();
    below.iter().flat_map(|path| files(path)).collect()
}

fn fingerprint() -> String {
    let mut hash = Fnv::default();
    for source in SOURCES {
        let source = repository().join(source);
        let begins = |path: &PathBuf| path.to_string_lossy().starts_with(&*source.to_string_lossy());
        let found: Vec<_> = files(source.parent().unwrap()).into_iter().filter(begins).collect();
        assert!(!found.is_empty(), "{} is not there", source.display());
        found.iter().for_each(|file| hash.bytes(&fs::read(file).unwrap()));
    }
    let lock = fs::read_to_string(repository().join("Cargo.lock")).unwrap();
    let used = |package: &&str| PACKAGES.iter().any(|name| package.starts_with(&format!("\nname = \"{name}\"\n")));
    lock.split("[[package]]").filter(used).for_each(|package| hash.bytes(package.as_bytes()));
    format!("{:016x}\n", hash.finish())
}

/// Whether a test that solves finite elements passed with the present sources, so that it is left
/// out.
pub fn solved_before() -> bool {
    let before = !long() && fs::read_to_string(golden()).is_ok_and(|text| text == fingerprint());
    println!("{}", if before { "left out: its sources have the fingerprint with which it passed" } else { "solved anew" });
    before
}

#[test]
#[ignore = "accepts the present sources"]
fn rewrite_the_fingerprint() {
    fs::write(golden(), fingerprint()).unwrap();
}
