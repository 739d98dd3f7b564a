//! A tick cannot panic. First, no function on the core's path calls a panic in the board's image,
//! in which every stage is a separate function. Second, a whole tick, from the host's message to
//! the outputs, links even with a panic handler that cannot be linked.

use std::path::Path;

use palpate_tests::disassembly;
use palpate_tests::emulator::{build_firmware, link_panic_proof};

/// Name prefixes of the path's functions in the image.
const PATH: [&str; 2] = ["palpate::tick::", "palpate::stages::"];

#[test]
fn no_function_of_the_path_calls_a_panic() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let elf = build_firmware(target, &["stage-cost"]).unwrap();
    let listing = disassembly::of(&elf);
    let mut function = String::new();
    let (mut seen, mut bad) = (Vec::new(), Vec::new());
    for line in listing.lines() {
        // example: "0000b35c <palpate::stages::force::spring::pull>:"
        if let Some(name) = line.split_once(" <").and_then(|(_, rest)| rest.strip_suffix(">:")) {
            function = name.trim_start_matches('<').to_string();
            if PATH.iter().any(|p| function.starts_with(p)) {
                seen.push(function.clone());
            }
        } else if PATH.iter().any(|p| function.starts_with(p)) && line.contains("panic") {
            bad.push(format!("{function}: {}", line.trim()));
        }
    }
    for stage in [
        "tick::tick",
        "probe::admit",
        "contact::find",
        "spring::pull",
        "armv7em::measure_tets",
        "armv7em::push_tets",
        "armv7em::pull_rows",
        "rim::hold",
        "foundation::press",
        "integrate::advance",
        "output::read",
    ] {
        assert!(
            seen.iter().any(|name| name.contains(&format!("{stage}::h"))),
            "{stage} is not in the image: nothing was proved; found {seen:?}"
        );
    }
    assert_eq!(bad, [""; 0]);
    assert!(listing.contains("panic"), "an image without any panic would prove nothing about where they are");
}

#[test]
fn a_tick_links_without_a_panic_and_with_one_it_does_not() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    link_panic_proof(target, false).unwrap();
    let planted = link_panic_proof(target, true).unwrap_err().to_string();
    assert!(planted.contains("undefined symbol: a_tick_can_panic"), "{planted}");
}
