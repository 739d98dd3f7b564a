//! `./test` runs everything with overflow checks and debug assertions: the core, the controller,
//! the emulated loop, and the `palpate` that tests start.

use std::collections::BTreeSet;
use std::hint::black_box;

use palpate_tests::palpate_command::{binary, repository};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
/// Variables that are set for the whole of `./test`; every cargo that a test starts inherits them.
const SWITCHES: [&str; 2] = ["CARGO_PROFILE_RELEASE_OVERFLOW_CHECKS", "CARGO_PROFILE_RELEASE_DEBUG_ASSERTIONS"];

/// Whether the checks are on. A single test that is run by hand without them is built like a user's
/// `palpate`.
fn switched_on() -> bool {
    let on = SWITCHES.iter().all(|name| std::env::var(name).is_ok_and(|value| value == "true"));
    if !on {
        println!("skipped: {} are not set to true; ./test sets them", SWITCHES.join(" and "));
    }
    on
}

#[test]
fn the_scripts_switch_them_on_and_the_boards_image_stays_without() {
    for script in ["test", "host-sim/lab/test"] {
        let text = std::fs::read_to_string(repository().join(script)).unwrap();
        assert!(SWITCHES.iter().all(|name| text.contains(&format!("{name}=true"))), "{script} sets them");
    }
    // the flashed image has no overflow checks: arithmetic that may wrap does so explicitly
    let manifest = std::fs::read_to_string(repository().join("Cargo.toml")).unwrap();
    let image = manifest.split("[profile.firmware]").nth(1).expect("the image's profile");
    let image = image.split("\n[").next().unwrap();
    assert!(image.contains("overflow-checks = false") && image.contains("debug-assertions = false"), "{image}");
}

#[test]
fn a_test_stops_where_a_number_overflows() {
    if switched_on() {
        #[expect(clippy::assertions_on_constants, reason = "the constant is what is tested")]
        {
            assert!(cfg!(debug_assertions));
        }
        assert!(std::panic::catch_unwind(|| black_box(i8::MAX) + black_box(1)).is_err());
    }
}

/// Paths of source files below `folder` that occur in the program as locations of possible panics.
/// Elsewhere in the program, for example in line tables, file names appear without their folder.
fn can_panic(program: &[u8], folder: &str) -> BTreeSet<String> {
    let starts = program.windows(folder.len()).enumerate().filter(|(_, bytes)| *bytes == folder.as_bytes());
    let paths = starts.filter_map(|(at, _)| {
        let path = program[at..].split(|b| !(b.is_ascii_lowercase() || b"/_.-".contains(b))).next()?;
        let end = path.windows(3).position(|bytes| bytes == b".rs")? + 3;
        Some(String::from_utf8_lossy(&path[..end]).into_owned())
    });
    paths.collect()
}

/// Built without the checks, no code that a tick runs can panic. So a possible panic in one of its
/// files proves that the file was built with the checks.
#[test]
fn core_controller_and_loop_in_the_program_that_tests_start_are_checked() {
    if !switched_on() {
        return;
    }
    let program = std::fs::read(binary(SCRATCH)).unwrap();
    let core: BTreeSet<_> =
        ["core/src/haptic/", "core/src/stages/"].iter().flat_map(|folder| can_panic(&program, folder)).collect();
    let (link, looped) =
        (can_panic(&program, "firmware/controller/src/link/"), can_panic(&program, "host-sim/loop/src/closed_loop/"));
    println!("{core:?}\n{link:?}\n{looped:?}");
    assert!(core.len() > 2, "{core:?}");
    assert!(!link.is_empty() && looped.len() > 4, "{link:?} {looped:?}");
}
