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
        "palpate-emulated.bin",
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
fn a_file_for_the_boot_loader_of_a_pico_2_holds_the_binary_in_numbered_blocks() {
    const FLASH: u32 = 0x1000_0000;
    const ARM_SECURE: u32 = 0xE48B_FF59;
    let desk = tempfile::tempdir().unwrap();
    let [binary, out] = ["a.bin", "a.uf2"].map(|name| desk.path().join(name));
    let written: Vec<u8> = (0..700_u32).map(|n| ((n * n) >> 3) as u8).collect();
    std::fs::write(&binary, &written).unwrap();
    assert!(Command::new(repository().join("host-sim/uf2")).args([&binary, &out]).status().unwrap().success());
    let mut read = Vec::new();
    for (n, block) in std::fs::read(&out).unwrap().chunks(512).enumerate() {
        let words: Vec<u32> = block.chunks(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect();
        let head = [0x0A32_4655, 0x9E5D_5157, 0x2000, FLASH + 256 * n as u32, 256, n as u32, 3, ARM_SECURE];
        assert_eq!((&words[..8], words[127]), (&head[..], 0x0AB1_6F30), "block {n}");
        read.extend_from_slice(&block[32..288]);
    }
    assert_eq!((&read[..700], read.len()), (&written[..], 768));
    let refused = Command::new(repository().join("host-sim/uf2")).arg(desk.path().join("none.bin")).arg(&out).status().unwrap();
    assert_eq!(refused.code(), Some(2));
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
