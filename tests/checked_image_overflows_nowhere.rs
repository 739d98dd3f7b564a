//! The emulated image with overflow checks and debug assertions runs the scripted hand to its end,
//! with the state of the desktop; an overflow that is planted ends the run with the outputs off.

use std::path::{Path, PathBuf};

use palpate::Fnv;
use palpate::haptic::cycle::{Command, Settings};
use palpate::haptic::device::HapticDevice;
use palpate_firmware::controller::{Arming, Controller};
use palpate_firmware::edge::Edge;
use palpate_firmware::patch::{self, Memory, Patch};
use palpate_firmware::script::{self, LEAD_TICKS};
use palpate_tests::emulator::{Machine, Run, RunResult, build_checked_firmware, build_firmware};

/// A tap, a hold, a slow way out and a slide.
const TICKS: u32 = LEAD_TICKS + 2_000;
/// The checks cost time: at 4 ns an instruction a tick still ends within its millisecond.
const SHIFT: u32 = 2;
/// The planted sum that overflows.
const OVERFLOW: usize = 17;

fn target() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap().to_path_buf()
}

fn run(elf: &Path, ticks: u32, planted: Option<usize>) -> palpate_tests::emulator::Outcome {
    Run { machine: Machine::An386, shift: SHIFT, ticks, lead_ticks: LEAD_TICKS, planted, exec_log: None }.start(elf).unwrap()
}

fn on_desktop() -> RunResult {
    let mut memory = Box::new(Memory::RESERVED);
    let mut patch = Patch::open(patch::in_flash(), &mut memory, None).unwrap();
    let mut controller = Controller::build(&Settings::safe(&Edge::DESKTOP.limits()), Edge::DESKTOP, Arming::ByItself).unwrap();
    let mut forces = Fnv::default();
    let mut most_n = 0.0_f32;
    for tick in 0..TICKS {
        let record = controller.step(&mut patch, script::sensed(tick, LEAD_TICKS), Command::HEARD, true);
        forces.vector(record.applied_n);
        most_n = most_n.max(record.applied_n.z);
    }
    assert!(most_n > 0.05, "the script missed the tissue: {most_n} N");
    RunResult { state_hash: patch.state_hash(), force_hash: forces.finish(), ticks: TICKS, overruns: 0, faults: 0 }
}

#[test]
fn a_checked_image_runs_the_script_to_its_end_in_the_state_of_the_desktop() {
    let outcome = run(&build_checked_firmware(&target(), &[]).unwrap(), TICKS, None);
    assert_eq!(outcome.result().unwrap(), on_desktop(), "{}", outcome.text);
    assert_eq!(outcome.exit_status, Some(0));
    println!("longest tick: {} ns at {} ns an instruction", outcome.number("longest_tick_ns").unwrap(), 1 << SHIFT);
}

#[test]
fn a_planted_overflow_ends_the_checked_image_and_passes_the_flashed_one_by() {
    let checked = run(&build_checked_firmware(&target(), &["planted-crash"]).unwrap(), 50, Some(OVERFLOW));
    assert!(checked.text.contains("attempt to add with overflow"), "{}", checked.text);
    assert!(checked.text.contains("outputs off") && !checked.text.contains("OUTPUTS ON"), "{}", checked.text);
    let flashed = run(&build_firmware(&target(), &["planted-crash"]).unwrap(), 50, Some(OVERFLOW));
    assert!(!flashed.text.contains("overflow"), "{}", flashed.text);
    assert_eq!(flashed.result().unwrap().ticks, 50, "{}", flashed.text);
}
