//! What the controller does when the core is too slow for its millisecond. Slowness is the emulator's: every instruction takes 2^shift ns.

use std::path::Path;

use palpate_firmware::script::LEAD_TICKS;
use palpate_tests::emulator::{Machine, Outcome, Run, build_firmware};

fn run(shift: u32) -> Outcome {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let elf = build_firmware(target, &[]).unwrap();
    Run { machine: Machine::An386, shift, ticks: 1_000, lead_ticks: LEAD_TICKS, planted: None, exec_log: None }
        .start(&elf)
        .unwrap()
}

#[test]
fn two_periods_missed_in_a_row_are_a_fault() {
    // 1.2 ms a tick: one period each of two ticks; 2.4 ms: two of the first
    for (shift, late) in [(4, 2), (5, 1)] {
        let outcome = run(shift);
        let result = outcome.result().unwrap();
        assert_eq!(result.overruns, late, "late ticks until the fault");
        // boot, self-test, the tick that puts the patch to rest, and the late ones
        assert_eq!(result.faults, 1_000 - 3 - late, "{}", outcome.text);
        assert!(outcome.text.contains("mode=fault fault=ticks ended too late"), "{}", outcome.text);
        assert_eq!(outcome.exit_status, Some(1));
    }
}

#[test]
fn a_tick_without_end_meets_the_watchdog() {
    let outcome = run(8); // 20 ms a tick, past the watchdog's 4.5 ms
    let silent_us = outcome.number("silent_us").unwrap_or_else(|| panic!("no word from the watchdog: {}", outcome.text));
    assert!(silent_us <= 5_000, "the outputs were off {silent_us} us after the last completed tick");
    assert_eq!(outcome.exit_status, Some(1));
}
