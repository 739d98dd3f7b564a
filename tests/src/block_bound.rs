//! A bound on a tick from the code of its image: every instruction, and every jump, as often as in
//! any tick of a run, and the waits for code in a flash by a rule. No tick of the run takes as
//! long, because blocks that exclude each other run most often in different ticks.

use std::collections::{BTreeMap, HashMap};

use crate::firmware_image::FirmwareImage;
use crate::instruction_mix::cycles_of;
use crate::thumb::{classify, is_wide};

/// Most cycles of a Cortex-M4F in a tick, without waits for memory, from the addresses that each
/// tick of a run executed.
///
/// # Panics
/// Panics if an address is not in the image.
pub fn cycles(image: &FirmwareImage, ticks: &[Vec<u32>]) -> f64 {
    let instruction = |address: u32| {
        let second = image.halfword_at(address + 2).unwrap_or(0);
        let first = image.halfword_at(address);
        first.and_then(|first| classify(first, second)).unwrap_or_else(|| panic!("{first:x?} {second:x} at {address:#x}"))
    };
    let mut most: BTreeMap<u32, [u32; 2]> = BTreeMap::new(); // times that it ran, and that it jumped
    for executed in ticks {
        let mut runs: HashMap<u32, [u32; 2]> = HashMap::new();
        for pair in executed.windows(2) {
            let [ran, jumped] = runs.entry(pair[0]).or_default();
            *ran += 1;
            *jumped += u32::from(pair[1] != pair[0] + instruction(pair[0]).bytes);
        }
        for (address, runs) in runs {
            let most = most.entry(address).or_default();
            *most = [most[0].max(runs[0]), most[1].max(runs[1])];
        }
    }
    let of = |(address, [ran, jumped]): (u32, [u32; 2])| {
        let [straight, jump] = cycles_of(instruction(address));
        f64::from(ran) * straight + f64::from(jumped) * (jump - straight)
    };
    most.into_iter().map(of).sum()
}

/// Addresses of the instructions in executed blocks, which are given by address and size. A place
/// outside the image is the model's, to which interrupts return.
pub fn instructions(image: &FirmwareImage, blocks: &[[u32; 2]]) -> Vec<u32> {
    let mut executed = Vec::new();
    for [mut at, bytes] in blocks.iter().copied() {
        let end = at + bytes;
        while let Some(first) = image.halfword_at(at).filter(|_| at < end) {
            executed.push(at);
            at += if is_wide(first) { 4 } else { 2 };
        }
    }
    executed
}

/// Address in the code of the constant that an instruction reads, if it reads one.
pub fn constant(image: &FirmwareImage, address: u32) -> Option<u32> {
    let [first, second] = [image.halfword_at(address)?, image.halfword_at(address + 2).unwrap_or(0)].map(u32::from);
    let (bytes, below) = match first {
        0x4800..=0x4FFF => (4 * (first & 0xFF), false),                            // ldr
        0xF85F | 0xF8DF => (second & 0xFFF, first & 0x80 == 0),                    // ldr.w
        _ if first & 0xFF3F == 0xED1F => (4 * (second & 0xFF), first & 0x80 == 0), // vldr
        _ => return None,
    };
    let from = (address + 4) & !3;
    Some(if below { from - bytes } else { from + bytes })
}

/// Flash of a chip, with the caches of its code and constants.
pub struct Flash {
    /// Bytes that one read gives, which is also the length of a line of a cache.
    pub line_bytes: u32,
    /// Lines of code that the cache holds.
    pub lines: usize,
    /// Lines of constants that the other cache holds.
    pub constants: usize,
    /// Cycles that the core waits for a read.
    pub waits: u32,
}

impl Flash {
    /// STM32F446 at 180 MHz: RM0390, 3.4 and table 5.
    pub const F446: Self = Self { line_bytes: 16, lines: 64, constants: 8, waits: 5 };
    /// STM32G474 at 170 MHz with two banks: RM0440, 3.3 and table 9.
    pub const G474: Self = Self { line_bytes: 8, lines: 128, constants: 32, waits: 4 };

    /// Cycles that code waits: for each line that is not among the last ones used. Lines that a
    /// prefetch would have read meanwhile are waited for as well.
    pub fn waited(&self, executed: impl IntoIterator<Item = u32>) -> f64 {
        self.missed(executed, self.lines)
    }

    /// Cycles that constants in the code wait.
    pub fn waited_for_constants(&self, read: impl IntoIterator<Item = u32>) -> f64 {
        self.missed(read, self.constants)
    }

    fn missed(&self, read: impl IntoIterator<Item = u32>, lines: usize) -> f64 {
        let mut kept: HashMap<u32, usize> = HashMap::new(); // line, and when it was used last
        let mut missed = 0;
        for (now, address) in read.into_iter().enumerate() {
            if kept.insert(address / self.line_bytes, now).is_none() {
                missed += 1;
                let oldest = kept.iter().min_by_key(|(_, used)| **used).map(|(line, _)| *line);
                if let Some(oldest) = oldest.filter(|_| kept.len() > lines) {
                    kept.remove(&oldest);
                }
            }
        }
        f64::from(self.waits) * f64::from(missed)
    }
}

#[cfg(test)]
mod tests {
    use super::Flash;

    #[test]
    fn a_loop_that_fits_the_cache_waits_once_and_a_longer_one_in_every_round() {
        let flash = Flash { line_bytes: 16, lines: 4, constants: 1, waits: 5 };
        let rounds = |bytes: u32| (0..10).flat_map(move |_| (0..bytes).step_by(2));
        assert_eq!(flash.waited(rounds(64)), 4.0 * 5.0);
        assert_eq!(flash.waited(rounds(80)), 10.0 * 5.0 * 5.0);
    }
}
