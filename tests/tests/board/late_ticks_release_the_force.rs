//! Behaviour of the controller on a core that is too slow for a tick per millisecond. The emulator
//! makes it slow: every instruction takes 2^shift ns.

use std::path::{Path, PathBuf};

use palpate_board::{EmulatedBoard, timed};
use palpate_controller::script::LEAD_TICKS;
use palpate_tests::crash::{Crash, Place, Planned};
use palpate_tests::emulator::{Outcome, Run, build_firmware};

/// Number of the slow tick, and its additional turns of a loop of two instructions.
const SLOW_TICK: u32 = 900;
const TURNS: u32 = 60_000;

fn image(features: &[&str]) -> PathBuf {
    build_firmware(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), features).unwrap()
}

fn run(shift: u32) -> Outcome {
    Run { machine: EmulatedBoard::M4f, shift, ticks: 1_000, lead_ticks: LEAD_TICKS, crash: None, restart: false, exec_log: None }
        .start(&image(&[]))
        .unwrap()
}

/// A run in which the tick with this number takes this many additional turns of a loop of two
/// instructions.
fn slow_at(tick: u32, turns: u32) -> Outcome {
    let run = Run {
        machine: EmulatedBoard::M4f,
        shift: 3,
        ticks: 1_000,
        lead_ticks: LEAD_TICKS,
        crash: Some(Planned { place: Place::Tick, pass: tick, crash: Crash::Dawdles(turns), starts: 1 }),
        restart: false,
        exec_log: None,
    };
    run.start(&image(&[])).unwrap()
}

#[test]
fn two_periods_missed_in_a_row_are_a_fault() {
    // a tick takes 1.6 to 2.0 ms, so each of two ticks misses one period
    let (shift, late) = (5, 2);
    let outcome = run(shift);
    let result = outcome.result().unwrap();
    assert_eq!(result.overruns, late, "late ticks until the fault");
    // not in `Fault`: boot, self-test, the tick that brings the patch to rest, and the late ticks
    assert_eq!(result.faults, 1_000 - 3 - late, "{}", outcome.text);
    assert!(outcome.text.contains("mode=fault fault=ticks ended too late"), "{}", outcome.text);
    assert_eq!(outcome.exit_status, Some(1));
}

#[test]
fn one_tick_that_misses_two_periods_is_a_fault() {
    let outcome = slow_at(SLOW_TICK, 2 * TURNS + TURNS / 6);
    let result = outcome.result().unwrap();
    assert_eq!(result.overruns, 1, "{}", outcome.text);
    // all ticks after the slow one
    assert_eq!(result.faults, 1_000 - SLOW_TICK, "{}", outcome.text);
    assert!(outcome.text.contains("mode=fault fault=ticks ended too late"), "{}", outcome.text);
    assert_eq!(outcome.exit_status, Some(1));
}

#[test]
fn a_tick_without_end_meets_the_watchdog() {
    let outcome = run(8); // 20 ms per tick, longer than the watchdog's 4.5 ms
    let silent_us = outcome.number("silent_us").unwrap_or_else(|| panic!("no word from the watchdog: {}", outcome.text));
    assert!(silent_us <= 5_000, "the outputs were off {silent_us} us after the last completed tick");
    assert_eq!(outcome.exit_status, Some(1));
}

#[test]
fn one_late_tick_is_counted_borne_and_forgotten() {
    let outcome = slow_at(SLOW_TICK, TURNS);
    let result = outcome.result().unwrap();
    assert_eq!((result.overruns, result.faults), (1, 0), "{}", outcome.text);
    let [missed, periods] = ["missed_periods", "periods"].map(|key| outcome.number(key).unwrap());
    assert_eq!((missed, periods), (1, u64::from(result.ticks) + missed), "{}", outcome.text);
    assert!(outcome.text.contains("mode=active fault=none"), "{}", outcome.text);
}

#[test]
fn ticks_start_on_time_and_however_slow_the_core_no_miss_is_uncounted() {
    let elf = image(&[]);
    let in_time = timed::run(&elf, EmulatedBoard::M4f, timed::IN_TIME_SHIFT, 2_000).unwrap();
    println!("{in_time:?}");
    assert_eq!((in_time.late_ticks, in_time.uncounted()), (Some(0), Some(0)));
    let [first, last] = in_time.start_instructions.unwrap();
    // the frames of the log are sent once per second with interrupts disabled
    assert!(first > 50.0 && last < 400.0, "ticks start {first} to {last} instructions after the timer's edge");
    let slow = timed::overruns(&elf, EmulatedBoard::M4f).unwrap();
    for run in &slow {
        println!("{run:?}");
        match run.watchdog_us {
            Some(silent_us) => assert!(silent_us <= 5_000, "{run:?}"),
            None => {
                assert!(run.uncounted() == Some(0) && run.late_ticks > Some(0) && run.ended.contains("fault=ticks"), "{run:?}");
            }
        }
    }
    assert!(slow.iter().any(|run| run.watchdog_us.is_some()) && slow.iter().any(|run| run.watchdog_us.is_none()));
}
