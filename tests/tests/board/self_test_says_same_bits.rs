//! The self-test image on two emulated boards: it runs without a host, ends with success and never
//! enables an output. Its report confirms that its results are bit-identical to this machine's, or
//! names the word that differs. The images that are flashed first run on the models of their chips.

use std::path::Path;

use palpate_board::EmulatedBoard;
use palpate_sim::port::self_test::Report;
use palpate_tests::emulator::{Run, build_firmware};
use palpate_tests::flash_patch::in_flash;
use palpate_tests::register_model::{self, Flashed, Period};
use serde_json::json;

/// Ticks after which a first report has arrived: those of the run, of the stages, and 0.3 s.
const REPORTED_TICKS: usize = 4_300;

fn run(machine: EmulatedBoard) -> String {
    let elf = build_firmware(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), &["self-test"]).unwrap();
    let run = Run { machine, shift: 3, ticks: 0, lead_ticks: 0, crash: None, restart: false, exec_log: None };
    let outcome = run.start(&elf).unwrap();
    assert_eq!(outcome.exit_status, Some(0), "{}", outcome.text);
    outcome.text
}

#[test]
fn both_boards_report_the_desktop_s_bits() {
    for machine in [EmulatedBoard::M4f, EmulatedBoard::M7] {
        let text = run(machine);
        let (report, line) = Report::find(&text).unwrap();
        println!("{}{line}", report.words());
        assert!(report.passed && report.error.is_empty(), "{line}");
        assert!(report.board.starts_with("mps2 ") && report.clock.contains("emulator"), "{line}");
        assert_eq!((report.checks.len(), report.checks.last().map(|check| check.tick)), (8, Some(report.ticks)));
        assert_eq!(report.compare(in_flash()).unwrap(), None, "{machine:?}");
        // each stage was timed, and the whole takes longer than the sum of its parts
        let of = |stage: &str| report.stage_counts[stage];
        let parts = ["contact", "springs", "volume", "foundation", "integrate"].map(of);
        assert!(parts.iter().all(|counts| *counts > 100), "{:?}", report.stage_counts);
        assert!(parts.iter().max().is_some_and(|longest| of("whole") > *longest));
        assert!(of("whole") < report.worst_tick_counts);
        assert!(report.stack_used_bytes > 1_000 && 2 * report.stack_used_bytes <= report.stack_bytes);
    }
}

#[test]
#[ignore = "long: 4 000 ticks on each of four models"]
fn the_self_tests_that_are_flashed_report_the_desktop_s_bits() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    for (board, advice) in
        [(Flashed::F446, "BOR_LEV=0"), (Flashed::G474, "BOR_LEV=4"), (Flashed::H743, "BOR_LEV=3"), (Flashed::Pico2, "")]
    {
        let (mut text, mut ticks) = (String::new(), 0);
        let probe = json!({"events": [{"at": 0, "how": "probe"}]});
        let journal = register_model::lock_step_image(target, board, &format!("selftest-{}", board.name()), &probe, |row| {
            text.push_str(&String::from_utf8_lossy(&row.sent));
            ticks += 1;
            let goes_on = ticks < REPORTED_TICKS && Report::find(&text).is_none();
            goes_on.then_some(Period { counts: [0; 3], says: None, late: 0 })
        });
        let Some(journal) = journal else { return };
        let (report, line) = Report::find(&text).unwrap_or_else(|| panic!("{board:?}: no report in {ticks} ticks: {text}"));
        println!("{}{line}", report.words());
        assert!(report.passed && report.compare(board.patch()).unwrap().is_none(), "{line}");
        assert!(journal.rows.iter().all(register_model::Row::is_off), "{board:?} drove an output");
        assert_eq!(journal.started.lost, 0, "a peripheral is written only once it has its clock");
        assert!(journal.rows.iter().all(|row| row.resets == 1), "{board:?} was reset");
        assert_eq!(report.words().contains("brown-out"), !advice.is_empty());
        assert!(report.words().contains(advice), "{}", report.words());
    }
}

#[test]
fn one_wrong_bit_is_named() {
    let text = run(EmulatedBoard::M4f);
    let (report, _) = Report::find(&text).unwrap();
    let mut spoilt = report.clone();
    spoilt.checks[5].forces.replace_range(15..16, if report.checks[5].forces.ends_with('0') { "1" } else { "0" });
    let difference = spoilt.compare(in_flash()).unwrap().unwrap();
    assert_eq!((difference.tick, difference.word), (report.checks[5].tick, "forces"));
    assert_eq!(difference.here, report.checks[5].forces);
    // a report whose check ticks are never reached proves nothing
    let mut unmet = report.clone();
    unmet.checks[7].tick += 1;
    assert!(unmet.compare(in_flash()).unwrap().is_some());
    // neither does a truncated line
    assert!(Report::find(&text.replace("]}", "")).is_none());
}
