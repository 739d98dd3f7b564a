//! The firmware on two emulated boards, and the same core on this machine, end in the same state after the same forces.

use std::path::Path;

use palpate::Fnv;
use palpate_firmware::{patch, probe_in};
use palpate_tests::emulator::{Machine, Run, RunResult, build_firmware};

const TICKS: u32 = 10_000;

fn on_desktop() -> (u64, u64) {
    let mut patch = patch::load().unwrap();
    let mut forces = Fnv::default();
    for tick in 0..TICKS {
        let output = patch.tick(probe_in::pose(probe_in::scripted(tick)));
        assert_eq!(output.fault, None, "tick {tick}");
        forces.vector(output.force_n);
    }
    (patch.state_hash(), forces.finish())
}

#[test]
fn board_and_desktop_give_the_same_bits() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let elf = build_firmware(target, &[]).unwrap();
    let (state_hash, force_hash) = on_desktop();
    let expected = RunResult { state_hash, force_hash, ticks: TICKS, overruns: 0, faults: 0 };
    for machine in [Machine::An386, Machine::An500] {
        let outcome = Run { machine, shift: 3, ticks: TICKS, exec_log: None }.start(&elf).unwrap();
        assert_eq!(outcome.result().unwrap(), expected, "{machine:?}");
        assert_eq!(outcome.exit_status, Some(0), "{machine:?}");
        let messages = outcome.messages(&std::fs::read(&elf).unwrap());
        assert_eq!(RunResult::parse(&messages), Some(expected.clone()), "the log says otherwise:\n{messages}");
    }
}
