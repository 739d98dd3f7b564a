//! The firmware on two emulated boards and the same controller on this machine compute the same
//! forces and end in the same state: for a whole block, and for a patch of a liver with rim
//! springs, pressed at its own site along its own axis.

use std::path::Path;

use palpate::haptic::cycle::{Command, Settings};
use palpate::haptic::device::HapticDevice;
use palpate::haptic::mode::Mode;
use palpate::{Fnv, PatchFile};
use palpate_board::EmulatedBoard;
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::patch::{Memory, Patch};
use palpate_controller::port::Port;
use palpate_controller::script::{self, LEAD_TICKS};
use palpate_tests::emulator::{Run, RunResult, build_checked_firmware, build_firmware, build_firmware_with};
use palpate_tests::flash_patch::in_flash;
use palpate_tests::packed;
use palpate_tests::share::long;

/// Ticks of a run: one round of the script's taps, holds and slides, or ten seconds in the long
/// form.
fn ticks() -> u32 {
    if long() { 10_000 } else { 4_000 }
}

/// Smallest peak force that proves contact in the scripted press of 4 mm [N]. Soft tissue of 3.5
/// kPa gives at least 0.1 N.
const FELT_N: f32 = 0.05;

fn on_desktop(bytes: &[u8], ticks: u32) -> RunResult {
    let mut memory = Box::new(Memory::RESERVED);
    let mut patch = Patch::open(bytes, &mut memory, None).unwrap();
    let mut controller = Controller::build(&Settings::safe(&Port::DESKTOP.limits()), Port::DESKTOP, Arming::ByItself).unwrap();
    let mut forces = Fnv::default();
    let (mut most_n, mut modes) = (0.0_f32, vec![Mode::Boot]);
    for tick in 0..ticks {
        let record = controller.tick(&mut patch, script::sensed(tick, LEAD_TICKS), Command::HEARD, true);
        assert_eq!(record.fault, None, "tick {tick}");
        forces.vector(record.applied_n);
        most_n = most_n.max(record.applied_n.z);
        if modes.last() != Some(&record.mode) {
            modes.push(record.mode);
        }
    }
    println!("largest force against the press: {most_n:.3} N; {modes:?}");
    assert!(most_n > FELT_N, "the script missed the tissue: {most_n} N");
    assert_eq!(modes, [Mode::Boot, Mode::SelfTest, Mode::Idle, Mode::Arming, Mode::Active]);
    RunResult { state_hash: patch.state_hash(), force_hash: forces.finish(), ticks, overruns: 0, faults: 0 }
}

fn agree(elf: &Path, expected: &RunResult) {
    for machine in [EmulatedBoard::M4f, EmulatedBoard::M7] {
        let outcome =
            Run { machine, shift: 3, ticks: ticks(), lead_ticks: LEAD_TICKS, crash: None, restart: false, exec_log: None }
                .start(elf)
                .unwrap();
        assert_eq!(&outcome.result().unwrap(), expected, "{machine:?}");
        assert_eq!(outcome.exit_status, Some(0), "{machine:?}");
        let messages = outcome.messages(&std::fs::read(elf).unwrap());
        assert_eq!(RunResult::parse(&messages).as_ref(), Some(expected), "the log says otherwise:\n{messages}");
    }
}

fn target() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap()
}

#[test]
fn board_and_desktop_give_the_same_bits() {
    let elf = build_firmware(target(), &[]).unwrap();
    agree(&elf, &on_desktop(in_flash(), ticks()));
}

/// An image with another patch than the default one. `emulated_board_equals_the_desktop` sends the
/// same patch to the default image.
#[test]
#[ignore = "long: one more image"]
fn a_packed_liver_gives_the_same_bits() {
    let file = packed::shipped("liver-m4f-168.patch");
    let bytes = packed::on_words(&file);
    let rim = PatchFile::open(bytes).unwrap().model.rim_edges.len();
    assert!(rim > 0, "a patch without rim springs proves nothing here");
    agree(&build_firmware_with(target(), &[], &file).unwrap(), &on_desktop(bytes, ticks()));
}

/// The image with overflow checks and debug assertions runs the script to its end. The checks cost
/// time: at 4 ns per instruction a tick still ends within its millisecond.
#[test]
fn checked_image_overflows_nowhere() {
    let checked = build_checked_firmware(target()).unwrap();
    let ticks = LEAD_TICKS + 2_000;
    let run =
        Run { machine: EmulatedBoard::M4f, shift: 2, ticks, lead_ticks: LEAD_TICKS, crash: None, restart: false, exec_log: None };
    let outcome = run.start(&checked).unwrap();
    assert_eq!(outcome.result().unwrap(), on_desktop(in_flash(), ticks), "{}", outcome.text);
    assert_eq!(outcome.exit_status, Some(0));

    let says = |elf: &Path| {
        let image = std::fs::read(elf).unwrap();
        image.windows(28).any(|text| text == b"attempt to add with overflow")
    };
    assert!(says(&checked) && !says(&build_firmware(target(), &[]).unwrap()));
}
