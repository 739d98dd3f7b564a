//! A probe with friction on the emulated board. A patch with a friction coefficient gives results
//! that are bit-identical to the desktop's through presses, faults and recovery, and it costs no
//! more than the board counts for it.

use std::path::Path;

use palpate::{MOST_TERMS, PatchFile, PronyTerm};
use palpate_board::timing::Spread;
use palpate_board::{Board, EmulatedBoard, Lockstep, campaign};
use palpate_controller::patch::{Memory, cost};
use palpate_tests::emulator::build_firmware;
use palpate_tests::packed;

const MEAT: [PronyTerm; MOST_TERMS] =
    [PronyTerm { share: 0.26, time_s: 0.4 }, PronyTerm { share: 0.31, time_s: 4.4 }, PronyTerm::NONE];
const NONE: [PronyTerm; MOST_TERMS] = [PronyTerm::NONE; MOST_TERMS];
const TICKS: u32 = 3_000;

/// The shipped block's patch file with this friction and relaxation, aligned to a word boundary.
/// The memory is never freed.
fn with(friction: f32, relaxation: [PronyTerm; MOST_TERMS]) -> &'static [u8] {
    let mut file = PatchFile::open(packed::on_words(&packed::shipped("block-m4f-168.patch"))).unwrap();
    (file.params.friction, file.params.relaxation) = (friction, relaxation);
    let mut bytes = Vec::new();
    file.write(|piece| bytes.extend_from_slice(piece));
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("rubbing-{friction}-{}.patch", relaxation[0].share));
    std::fs::write(&path, bytes).unwrap();
    packed::on_words(&path)
}

fn run(patch: &'static [u8]) -> Spread {
    let image = build_firmware(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), &[]).unwrap();
    let mut memory = Box::new(Memory::RESERVED);
    let board = Board::start(&image, EmulatedBoard::M4f, None).unwrap();
    let mut twin = Lockstep::new(board, patch, &mut memory).unwrap();
    let met = campaign::run(&mut twin, TICKS, 4e-3, |_| ()).unwrap();
    assert_eq!(twin.difference, None);
    assert!(met.felt > 200 && met.recovered > 0, "{met:?}");
    Spread::of(&twin.instructions)
}

#[test]
fn board_and_desktop_rub_to_the_same_bits_at_the_cost_that_is_counted() {
    let patches = [with(0.0, NONE), with(0.5, NONE), with(0.0, MEAT), with(0.5, MEAT)];
    let [none, rubs, relaxes, both] = patches.map(run);
    let cycles = patches.map(|patch| cost::cycles(&PatchFile::open(patch).unwrap(), 17));
    for (name, spread, cycles) in [
        ("none", &none, cycles[0]),
        ("friction", &rubs, cycles[1]),
        ("relaxation", &relaxes, cycles[2]),
        ("both", &both, cycles[3]),
    ] {
        println!("{name}: {} instructions at most, {} median; {cycles:.0} cycles are counted", spread.max, spread.median);
    }
    // the bound for friction: 5 % of the longest tick when the bound was set, 74 600 instructions.
    // An instruction takes at least one cycle
    for (with, without, counted) in [(rubs, none, cycles[1] - cycles[0]), (both, relaxes, cycles[3] - cycles[2])] {
        assert!(f64::from(counted) >= (with.max - without.max) as f64, "{counted} cycles counted");
        let more = with.max.saturating_sub(without.max) as f64;
        assert!(more > 70.0 && more < 0.05 * 74_600.0, "{} instructions, {} without", with.max, without.max);
    }
}
