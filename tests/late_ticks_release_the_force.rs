//! What the controller does when the core is too slow for its millisecond. Slowness is the emulator's: every instruction takes 2^shift ns.

use std::path::Path;

use palpate_tests::emulator::{Machine, Outcome, Run, build_firmware};

fn run(shift: u32) -> Outcome {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let elf = build_firmware(target, &[]).unwrap();
    Run { machine: Machine::An386, shift, ticks: 100, exec_log: None }.start(&elf).unwrap()
}

#[test]
fn three_late_ticks_in_a_row_release_the_force_for_good() {
    let outcome = run(5); // 2 ms a tick
    let result = outcome.result().unwrap();
    assert_eq!(result.overruns, 3, "late ticks until the release");
    assert_eq!(result.faults, 98, "the third late tick and all after it");
    assert_eq!(outcome.exit_status, Some(1));
}

#[test]
fn a_tick_without_end_meets_the_watchdog() {
    let outcome = run(8); // 16 ms a tick, past the watchdog's 10 ms
    assert!(outcome.text.contains("watchdog"), "{}", outcome.text);
    assert_eq!(outcome.exit_status, Some(1));
}
