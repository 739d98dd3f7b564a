//! Tissue that relaxes on the emulated board. A patch with relaxation shares and times gives
//! results that are bit-identical to the desktop's through presses, faults and recovery, and its
//! cost stays within a bound.

use std::path::Path;

use palpate::{MOST_TERMS, PatchFile, PronyTerm};
use palpate_board::timing::Spread;
use palpate_board::{Board, EmulatedBoard, Lockstep, campaign};
use palpate_controller::patch::{Memory, cost};
use palpate_tests::emulator::build_firmware;
use palpate_tests::packed;

const TERMS: [PronyTerm; MOST_TERMS] =
    [PronyTerm { share: 0.26, time_s: 0.4 }, PronyTerm { share: 0.31, time_s: 4.4 }, PronyTerm { share: 0.1, time_s: 0.02 }];
const TICKS: u32 = 3_000;

/// The shipped block's patch file with this many terms, aligned to a word boundary. The memory is
/// never freed.
fn with_terms(terms: usize) -> &'static [u8] {
    let mut file = PatchFile::open(packed::on_words(&packed::shipped("block-m4f-168.patch"))).unwrap();
    file.params.relaxation = std::array::from_fn(|n| if n < terms { TERMS[n] } else { PronyTerm::NONE });
    let mut bytes = Vec::new();
    file.write(|piece| bytes.extend_from_slice(piece));
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("relaxing-{terms}.patch"));
    std::fs::write(&path, bytes).unwrap();
    packed::on_words(&path)
}

fn run(terms: usize) -> Spread {
    let image = build_firmware(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), &[]).unwrap();
    let mut memory = Box::new(Memory::RESERVED);
    let board = Board::start(&image, EmulatedBoard::M4f, None).unwrap();
    let mut twin = Lockstep::new(board, with_terms(terms), &mut memory).unwrap();
    let met = campaign::run(&mut twin, TICKS, 4e-3, |_| ()).unwrap();
    assert_eq!(twin.difference, None, "{terms} terms");
    assert!(met.felt > 200 && met.recovered > 0, "{met:?}");
    Spread::of(&twin.instructions)
}

#[test]
fn board_and_desktop_relax_to_the_same_bits_at_the_cost_that_is_counted() {
    let spread = [0, 1, 2, 3].map(run);
    let cycles = [0, 1, 2, 3].map(|terms| cost::cycles(&PatchFile::open(with_terms(terms)).unwrap(), 17));
    for (terms, (spread, cycles)) in spread.iter().zip(cycles).enumerate() {
        println!("{terms} terms: {} instructions at most, {} median; {cycles:.0} cycles are counted", spread.max, spread.median);
    }
    // the bound for two terms: 6 % of the compiled tick of 57 nodes when the bound was set, 71 900
    // instructions
    let nodes = PatchFile::open(with_terms(0)).unwrap().model.nodes.len() as f64;
    let [none, _, two, _] = spread.map(|s| s.median as f64);
    assert!((two - none) / nodes < 0.06 * 71_900.0 / 57.0, "{two} instructions, {none} without");
}
