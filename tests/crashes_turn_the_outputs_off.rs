//! Whatever crashes, the outputs are off within 200 instructions, before a word is said about it; a loop that hangs is ended by the watchdog, and a board
//! that hangs again and again stays idle. Crashes are planted at twelve sites; instructions are counted in the emulator's log.

use std::io::BufReader;
use std::path::{Path, PathBuf};

use palpate_tests::emulator::{Machine, Outcome, Run, build_firmware};
use palpate_tests::exec_log::ExecLog;
use palpate_tests::firmware_image::FirmwareImage;

/// Instructions from the crash to outputs that are off.
const MOST_INSTRUCTIONS: usize = 200;
/// Time from the last completed tick to outputs that are off [us].
const MOST_SILENT_US: u64 = 5_000;
/// What each site says when it is met.
const SITES: [&str; 12] = [
    "planted",
    "index out of bounds",
    "planted",
    "attempt to divide by zero",
    "planted",
    "hard fault at pc",
    "hard fault at pc",
    "hard fault at pc",
    "the stack overflowed",
    "the stack overflowed",
    "the stack overflowed",
    "interrupt 20 has no handler",
];
/// Where the pins hold a force after every tick that the loop did not ask for.
const FORCED: usize = 15;
/// Where the haptic loop never ends, and where the tick timer stops.
const HANGS: [usize; 2] = [12, 13];

fn image() -> PathBuf {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    build_firmware(target, &["planted-crash"]).unwrap()
}

fn run(elf: &Path, site: usize, ticks: u32, log: Option<&Path>) -> Outcome {
    Run { machine: Machine::An386, shift: 3, ticks, lead_ticks: 5, planted: Some(site), exec_log: log }.start(elf).unwrap()
}

/// Instructions after the last one of the planted function until control leaves `outputs_off`.
fn until_off(image: &FirmwareImage, log: &Path) -> usize {
    let (mut since, mut inside) = (None, false);
    for address in ExecLog::new(BufReader::new(std::fs::File::open(log).unwrap())) {
        let name = image.function_at(address.unwrap()).map_or("", |f| f.name.as_str());
        let planted = ["plant::", "mps2::crash::"].iter().any(|p| name.contains(p)) && !name.ends_with("plant::pass");
        let off = ["mps2::outputs_off", "mps2::write_outputs"].iter().any(|end| name.ends_with(end));
        match since {
            _ if planted => since = Some(0),
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
    for (site, says) in SITES.into_iter().enumerate() {
        let log = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("crash-{site}.log"));
        let outcome = run(&elf, site, 6, Some(&log));
        assert!(outcome.text.contains(says), "site {site}: {}", outcome.text);
        assert!(outcome.text.contains("outputs off"), "site {site}: {}", outcome.text);
        assert_eq!(outcome.exit_status, Some(1), "site {site}");
        let instructions = until_off(&read, &log);
        println!("site {site:>2}: outputs off after {instructions} instructions ({says})");
        assert!((5..=MOST_INSTRUCTIONS).contains(&instructions), "site {site}: {instructions} instructions");
        std::fs::remove_file(&log).unwrap();
    }
}

#[test]
fn a_board_that_hangs_is_turned_off_reset_and_after_the_third_time_stays_idle() {
    let elf = image();
    for site in HANGS {
        let outcome = run(&elf, site, 1_000, None);
        let silent: Vec<u64> = outcome.text.split("silent_us=").skip(1).map(|rest| digits(rest).parse().unwrap()).collect();
        println!("site {site}: watchdog after {silent:?} us");
        assert_eq!(silent.len(), 3, "site {site}: {}", outcome.text);
        assert!(silent.iter().all(|us| *us <= MOST_SILENT_US), "site {site}: {silent:?}");
        // the fourth start ends its thousand ticks, but nobody may feel anything
        assert!(outcome.text.contains("mode=idle fault=none"), "site {site}: {}", outcome.text);
        assert_eq!(outcome.result().unwrap().ticks, 1_000);
    }
}

#[test]
fn a_force_on_the_pins_that_nobody_asked_for_is_off_with_the_tick_and_a_fault() {
    let outcome = run(&image(), FORCED, 50, None);
    // fed by no tick, the watchdog ends it all the same
    assert!(outcome.text.contains("watchdog"), "{}", outcome.text);
    assert!(!outcome.text.contains("OUTPUTS ON"), "{}", outcome.text);
    let once = run(&image(), FORCED + 1, 50, None);
    assert!(once.text.contains("mode=fault fault=the self-test failed"), "{}", once.text);
    assert_eq!(once.result().unwrap().ticks, 50, "{}", once.text);
}

fn digits(text: &str) -> &str {
    text.split(|c: char| !c.is_ascii_digit()).next().unwrap_or_default()
}
