//! Tissue that stiffens, on the emulated board: a patch that carries an exponent gives the same bits
//! as on the desktop through presses, faults and recovery, and costs what the board counts with. On
//! the M7: the M4F has no time for this patch when it stiffens, and refuses it.

use std::path::Path;

use palpate::PatchFile;
use palpate_board::timing::Spread;
use palpate_board::{Board, EmulatedBoard, Twin, campaign};
use palpate_controller::patch::{Memory, cost};
use palpate_tests::emulator::build_firmware;
use palpate_tests::packed;

const TICKS: u32 = 3_000;
/// Instructions in a tick of the shipped patch of 57 nodes over those without the term (1).
const MOST: f64 = 1.30;

/// The shipped block with an exponent, on a word boundary, for ever.
fn with_exponent(stiffening_b: f32) -> &'static [u8] {
    let mut file = PatchFile::open(packed::on_words(&packed::shipped("block-m4f-168.patch"))).unwrap();
    file.params.stiffening_b = stiffening_b;
    let mut bytes = Vec::new();
    file.write(|piece| bytes.extend_from_slice(piece));
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("stiffening-{stiffening_b}.patch"));
    std::fs::write(&path, bytes).unwrap();
    packed::on_words(&path)
}

fn run(stiffening_b: f32) -> Spread {
    let image = build_firmware(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), &[]).unwrap();
    let mut memory = Box::new(Memory::RESERVED);
    let board = Board::start(&image, EmulatedBoard::M7, None).unwrap();
    let mut twin = Twin::new(board, with_exponent(stiffening_b), &mut memory).unwrap();
    let met = campaign::run(&mut twin, TICKS, 4e-3, |_| ()).unwrap();
    assert_eq!(twin.difference, None, "b = {stiffening_b}");
    assert!(met.felt > 200 && met.recovered > 0, "{met:?}");
    Spread::of(&twin.instructions)
}

#[test]
fn board_and_desktop_stiffen_to_the_same_bits_at_the_cost_that_is_counted() {
    let [without, with] = [0.0, 0.3].map(run);
    let [plain, counted] = [0.0, 0.3].map(|b| f64::from(cost::cycles(&PatchFile::open(with_exponent(b)).unwrap(), 17)));
    let [median, max] = [with.median as f64 / without.median as f64, with.max as f64 / without.max as f64];
    println!("without: {} instructions at most, {} median; {plain:.0} cycles are counted", without.max, without.median);
    println!("with: {} instructions at most, {} median; {counted:.0} cycles are counted", with.max, with.median);
    assert!(median < MOST && max < MOST, "{median} in the median, {max} at most");
    // cycles are counted a little high
    assert!(counted / plain > max - 0.01 && counted / plain < MOST, "{} are counted for {max}", counted / plain);
}
