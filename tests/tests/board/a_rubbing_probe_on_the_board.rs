//! Tissue that relaxes and a probe with friction on the emulated board. Patches with these terms
//! give results that are bit-identical to the desktop's through presses, faults and recovery, and
//! cost no more than the board counts for them.

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

/// The shipped block's patch file with this many terms and this friction, aligned to a word
/// boundary. The memory is never freed.
fn with(terms: usize, friction: f32) -> &'static [u8] {
    let mut file = PatchFile::open(packed::on_words(&packed::shipped("block-m4f-168.patch"))).unwrap();
    file.params.relaxation = std::array::from_fn(|n| if n < terms { TERMS[n] } else { PronyTerm::NONE });
    file.params.friction = friction;
    let mut bytes = Vec::new();
    file.write(|piece| bytes.extend_from_slice(piece));
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("relaxing-{terms}-rubbing-{friction}.patch"));
    std::fs::write(&path, bytes).unwrap();
    packed::on_words(&path)
}

/// Instructions of a tick, and the cycles that the board counts for one.
fn run(terms: usize, friction: f32) -> (Spread, f64) {
    let patch = with(terms, friction);
    let image = build_firmware(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), &[]).unwrap();
    let mut memory = Box::new(Memory::RESERVED);
    let board = Board::start(&image, EmulatedBoard::M4f, None).unwrap();
    let mut twin = Lockstep::new(board, patch, &mut memory).unwrap();
    let met = campaign::run(&mut twin, TICKS, 4e-3, |_| ()).unwrap();
    assert_eq!(twin.difference, None, "{terms} terms, friction {friction}");
    assert!(met.felt > 200 && met.recovered > 0, "{met:?}");
    let (spread, file) = (Spread::of(&twin.instructions), PatchFile::open(patch).unwrap());
    let cycles = cost::cycles(&file, 17).into();
    println!("{terms} terms, friction {friction}: {spread:?}; {cycles:.0} cycles are counted");
    (spread, cycles)
}

#[test]
fn board_and_desktop_relax_and_rub_to_the_same_bits_at_the_cost_that_is_counted() {
    let [none, rubs, relaxes, both, _] = [(0, 0.0), (0, 0.5), (2, 0.0), (2, 0.5), (3, 0.0)].map(|(t, mu)| run(t, mu));
    // an instruction takes at least one cycle
    for (with, without) in [(&rubs, &none), (&both, &relaxes)] {
        let more = with.0.max.saturating_sub(without.0.max) as f64;
        assert!(with.1 - without.1 >= more, "{} cycles counted for {more} instructions", with.1 - without.1);
        // 5 % of the longest tick when the bound was set, 74 600 instructions
        assert!(more > 70.0 && more < 0.05 * 74_600.0, "{} instructions, {} without", with.0.max, without.0.max);
    }
    // 6 % of the compiled tick of 57 nodes when the bound was set, 71 900 instructions
    let nodes = PatchFile::open(with(0, 0.0)).unwrap().model.nodes.len() as f64;
    let more = (relaxes.0.median - none.0.median) as f64;
    assert!(more / nodes < 0.06 * 71_900.0 / 57.0, "{more} instructions for two terms");
}
