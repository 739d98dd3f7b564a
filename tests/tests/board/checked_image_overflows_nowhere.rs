//! The emulated image with overflow checks and debug assertions runs the scripted hand to its end
//! and reaches the same state as the desktop.

use std::path::{Path, PathBuf};

use palpate::Fnv;
use palpate::haptic::cycle::{Command, Settings};
use palpate::haptic::device::HapticDevice;
use palpate_board::EmulatedBoard;
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::patch::{Memory, Patch};
use palpate_controller::port::Port;
use palpate_controller::script::{self, LEAD_TICKS};
use palpate_tests::emulator::{Run, RunResult, build_checked_firmware, build_firmware};
use palpate_tests::flash_patch::in_flash;

/// Ticks of a tap, a hold, a slow retreat and a slide, after the wait.
const TICKS: u32 = LEAD_TICKS + 2_000;
/// The checks cost time: at 4 ns per instruction a tick still ends within its millisecond.
const SHIFT: u32 = 2;

fn target() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap().to_path_buf()
}

fn run(elf: &Path, ticks: u32) -> palpate_tests::emulator::Outcome {
    Run { machine: EmulatedBoard::M4f, shift: SHIFT, ticks, lead_ticks: LEAD_TICKS, crash: None, restart: false, exec_log: None }
        .start(elf)
        .unwrap()
}

fn on_desktop() -> RunResult {
    let mut memory = Box::new(Memory::RESERVED);
    let mut patch = Patch::open(in_flash(), &mut memory, None).unwrap();
    let mut controller = Controller::build(&Settings::safe(&Port::DESKTOP.limits()), Port::DESKTOP, Arming::ByItself).unwrap();
    let mut forces = Fnv::default();
    let mut most_n = 0.0_f32;
    for tick in 0..TICKS {
        let record = controller.tick(&mut patch, script::sensed(tick, LEAD_TICKS), Command::HEARD, true);
        forces.vector(record.applied_n);
        most_n = most_n.max(record.applied_n.z);
    }
    assert!(most_n > 0.05, "the script missed the tissue: {most_n} N");
    RunResult { state_hash: patch.state_hash(), force_hash: forces.finish(), ticks: TICKS, overruns: 0, faults: 0 }
}

#[test]
fn a_checked_image_runs_the_script_to_its_end_in_the_state_of_the_desktop() {
    let outcome = run(&build_checked_firmware(&target()).unwrap(), TICKS);
    assert_eq!(outcome.result().unwrap(), on_desktop(), "{}", outcome.text);
    assert_eq!(outcome.exit_status, Some(0));
    println!("longest tick: {} ns at {} ns an instruction", outcome.number("longest_tick_ns").unwrap(), 1 << SHIFT);
}

#[test]
fn the_checked_image_checks_its_sums_and_the_flashed_one_does_not() {
    let says = |elf: &Path| {
        let image = std::fs::read(elf).unwrap();
        image.windows(28).any(|text| text == b"attempt to add with overflow")
    };
    assert!(says(&build_checked_firmware(&target()).unwrap()));
    assert!(!says(&build_firmware(&target(), &[]).unwrap()));
}
