//! Refuses a patch that the image's board would refuse when it starts, by the board's own check.

use palpate_controller::patch::{Budget, Memory, Patch};

/// Clock of each board's core [Hz], by the feature that selects the board. The RP2350's counts as
/// 0.8, as on the board itself. The emulated boards accept whatever the faster of them does.
const CLOCKS_HZ: [(&str, f32); 5] =
    [("nucleo-f446re", 180e6), ("nucleo-g474re", 170e6), ("nucleo-h743zi", 480e6), ("pico2", 0.8 * 150e6), ("mps2", 480e6)];

/// Checks a patch for a board, which the feature `board` selects.
///
/// # Errors
/// The board would refuse the patch; the message says why, and what to do. A board that is not in
/// the list checks the patch when it starts.
pub fn fits(board: &str, bytes: &[u8]) -> Result<(), String> {
    let Some((_, clock_hz)) = CLOCKS_HZ.iter().find(|(name, _)| *name == board) else { return Ok(()) };
    let budget = Budget { cycles: Budget::M4F_168.cycles / 168e6 * clock_hz };
    // read in place as words, so on a boundary of words
    let words: Vec<u32> =
        bytes.chunks(4).map(|four| four.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte))).collect();
    let mut memory = Box::new(Memory::RESERVED);
    match Patch::open_within(&budget, bytemuck::cast_slice(&words), &mut memory, None, &mut || ()) {
        Ok(_) => Ok(()),
        Err(why) => {
            Err(format!("{board} does not run it: {why}; make one with `palpate fit --board {board}`, or take another board"))
        }
    }
}
