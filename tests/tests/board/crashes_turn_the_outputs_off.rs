//! After any crash the outputs are off within 200 instructions, before anything is reported. The
//! watchdog ends a hang, and a board that hangs repeatedly stays idle. A debugger plants the
//! crashes in the image that is flashed; instructions are counted in the emulator's log.

use std::io::BufReader;
use std::path::{Path, PathBuf};

use palpate_board::EmulatedBoard;
use palpate_tests::crash::{Crash, FILE, Place, Planned, is_of_crash};
use palpate_tests::emulator::{Outcome, Run, build_firmware};
use palpate_tests::exec_log::ExecLog;
use palpate_tests::firmware_image::FirmwareImage;

/// Largest number of instructions from the crash until the outputs are off.
const MOST_INSTRUCTIONS: usize = 200;
/// Longest time from the last completed tick until the outputs are off [us].
const MOST_SILENT_US: u64 = 5_000;
/// Number of the pass through the planted code at which it crashes.
const PASSES: u32 = 3;
/// Number of starts that crash, if the board restarts.
const STARTS: u32 = 3;
/// Every kind of crash and its message.
const CRASHES: [(Crash, &str); 6] = [
    (Crash::Panics, FILE),
    (Crash::RunsNoInstruction, "hard fault at pc"),
    (Crash::ReadsNowhere, "hard fault at pc"),
    (Crash::JumpsNowhere, "hard fault at pc"),
    (Crash::OverflowsTheStack, "the stack overflowed"),
    (Crash::PendsAStrayInterrupt, "interrupt 20 has no handler"),
];
const PLACES: [Place; 3] = [Place::Tick, Place::Timer, Place::Thread];

fn image() -> PathBuf {
    build_firmware(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), &[]).unwrap()
}

fn run(elf: &Path, crash: (Place, Crash), ticks: u32, restart: bool, log: Option<&Path>) -> Outcome {
    let starts = if restart { STARTS } else { 1 };
    let crash = Some(Planned { place: crash.0, pass: PASSES, crash: crash.1, starts });
    Run { machine: EmulatedBoard::M4f, shift: 3, ticks, lead_ticks: 5, crash, restart, exec_log: log }.start(elf).unwrap()
}

/// Instructions after the last one of the crash until control leaves `outputs_off`.
fn until_off(image: &FirmwareImage, log: &Path) -> usize {
    let (mut since, mut inside) = (None, false);
    for address in ExecLog::new(BufReader::new(std::fs::File::open(log).unwrap())) {
        let address = address.unwrap();
        let name = image.function_at(address).map_or("", |f| f.name.as_str());
        let off = ["mps2::outputs_off", "mps2::write_outputs"].iter().any(|end| name.ends_with(end));
        match since {
            _ if is_of_crash(address) => since = Some(0),
            Some(n) if inside && !off => return n,
            Some(n) => {
                inside |= name.ends_with("mps2::outputs_off");
                since = Some(n + 1);
            }
            None => {}
        }
    }
    panic!("the outputs were never turned off");
}

#[test]
fn every_crash_turns_the_outputs_off_within_two_hundred_instructions() {
    let elf = image();
    let read = FirmwareImage::parse(&std::fs::read(&elf).unwrap()).unwrap();
    for place in PLACES {
        for (crash, says) in CRASHES {
            // the default handler of an unhandled interrupt does not preempt an interrupt of equal
            // or higher priority
            if crash == Crash::PendsAStrayInterrupt && place == Place::Timer {
                continue;
            }
            let log = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("crash-{place:?}-{crash:?}.log"));
            // while a debugger is attached, the emulator's clock follows the host's: on a busy host
            // the watchdog may expire before the crash prints its own line
            let started = |_| run(&elf, (place, crash), 6, false, Some(&log));
            let outcome =
                (0..3).map(started).find(|o| !o.text.contains("watchdog")).expect("the watchdog came first, three times");
            assert!(outcome.text.contains(says), "{place:?} {crash:?}: {}", outcome.text);
            assert!(outcome.text.contains("outputs off"), "{place:?} {crash:?}: {}", outcome.text);
            assert_eq!(outcome.exit_status, Some(1), "{place:?} {crash:?}");
            let instructions = until_off(&read, &log);
            println!("{place:?} {crash:?}: outputs off after {instructions} instructions ({says})");
            assert!((5..=MOST_INSTRUCTIONS).contains(&instructions), "{place:?} {crash:?}: {instructions} instructions");
            std::fs::remove_file(&log).unwrap();
        }
    }
}

#[test]
fn a_board_that_hangs_is_turned_off_reset_and_after_the_third_time_stays_idle() {
    let elf = image();
    for hang in [(Place::Tick, Crash::Hangs), (Place::Thread, Crash::StopsTheTimer)] {
        let outcome = run(&elf, hang, 1_000, true, None);
        let silent: Vec<u64> = outcome.text.split("silent_us=").skip(1).map(|rest| digits(rest).parse().unwrap()).collect();
        println!("{hang:?}: watchdog after {silent:?} us");
        assert_eq!(silent.len(), 3, "{hang:?}: {}", outcome.text);
        assert!(silent.iter().all(|us| *us <= MOST_SILENT_US), "{hang:?}: {silent:?}");
        assert!(outcome.text.contains("outputs off") && !outcome.text.contains("OUTPUTS ON"), "{}", outcome.text);
        // the fourth start completes its thousand ticks, but without a force
        assert!(outcome.text.contains("mode=idle fault=none"), "{hang:?}: {}", outcome.text);
        assert_eq!(outcome.result().unwrap().ticks, 1_000);
    }
}

fn digits(text: &str) -> &str {
    text.split(|c: char| !c.is_ascii_digit()).next().unwrap_or_default()
}
