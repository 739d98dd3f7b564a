//! The quick form of the release script, and the contents of the core's package.

use std::path::Path;
use std::process::Command;

use palpate_tests::palpate_command::repository;

fn script(arguments: &[&str]) -> (Option<i32>, String, String) {
    let ran = Command::new(repository().join("host-sim/release")).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (ran.status.code(), text(ran.stdout), text(ran.stderr))
}

#[test]
fn a_quick_release_holds_its_files_and_their_checksums() {
    let desk = tempfile::tempdir().unwrap();
    let out = desk.path().join("artefacts");
    let (code, said, why) = script(&["--quick", "--out", &out.display().to_string()]);
    assert_eq!(code, Some(0), "{said}{why}");
    assert!(
        said.contains("left out: ") && said.lines().next_back().is_some_and(|line| line.starts_with("ok: palpate")),
        "{said}"
    );
    let sums = std::fs::read_to_string(out.join("SHA256SUMS")).unwrap();
    let package = format!("palpate-{}.crate", env!("CARGO_PKG_VERSION"));
    let named = |name: &str| sums.lines().any(|line| line.ends_with(&format!("  {name}")));
    for name in [
        &package,
        "palpate-emulated.elf",
        "block-m4f-168.patch",
        "palpate.h",
        "summary.schema.json",
        "LICENSE-MIT",
        "CHANGELOG.md",
    ] {
        assert!(named(name) && out.join(name).is_file(), "{name} in\n{sums}");
    }
    let check = |folder: &Path| Command::new("sha256sum").args(["--check", "--quiet", "SHA256SUMS"]).current_dir(folder).status();
    assert!(check(&out).unwrap().success());
    std::fs::write(out.join("palpate.h"), "changed").unwrap();
    assert!(!check(&out).unwrap().success());

    // the package must be usable and understandable without this repository
    let listed = Command::new("tar").arg("-tzf").arg(out.join(&package)).output().unwrap();
    let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
    for name in
        ["LICENSE-MIT", "LICENSE-APACHE", "README.md", "examples/controller.rs", "examples/block-m4f-168.patch", "src/tick.rs"]
    {
        assert!(listed.lines().any(|line| line.split_once('/').is_some_and(|(_, inside)| inside == name)), "{name} in\n{listed}");
    }
}

#[test]
fn a_folder_of_other_files_is_no_release() {
    let desk = tempfile::tempdir().unwrap();
    std::fs::write(desk.path().join("thesis.tex"), "mine").unwrap();
    let (code, said, why) = script(&["--quick", "--out", &desk.path().display().to_string()]);
    assert!(code == Some(2) && said.is_empty() && why.lines().count() == 1 && why.contains("choose a new folder"), "{said}{why}");
    assert_eq!(std::fs::read_to_string(desk.path().join("thesis.tex")).unwrap(), "mine");
    assert_eq!(script(&["--slow"]).0, Some(2));
}
