//! Instructions that a tick executes, function by function: exact counts, and the estimated number
//! of Cortex-M4F cycles.
//!
//! **Counts are exact, cycles are an estimate, neither is hardware timing.** The emulator has no
//! pipeline, no flash wait states and no bus contention. The estimate adds up the cycles of every
//! executed instruction on its own, from Arm DDI 0439B (Cortex-M4 technical reference manual),
//! tables 3-1 and 7-1. It leaves out the overlap of back-to-back loads, which makes it too high,
//! and stalls on results, which makes it too low.

use std::collections::BTreeMap;

use crate::{
    exec_log::LogError,
    firmware_image::FirmwareImage,
    thumb::{CLASSES, Class, Instruction, classify},
};

/// Why a log could not be turned into costs.
#[derive(Debug, thiserror::Error)]
pub enum MixError {
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// Code that is not in the image.
    #[error("executed address {0:#010x} is not in the image; was the log written by this ELF file?")]
    NoCode(u32),
    /// An opcode that is not in the table.
    #[error("opcode {first:#06x} {second:#06x} at {address:#010x} is in no class; add it to thumb.rs")]
    UnknownOpcode {
        /// Address in the image.
        address: u32,
        /// First halfword.
        first: u16,
        /// Second halfword, if the instruction has one.
        second: u16,
    },
    /// The function to measure is missing.
    #[error("no function `{0}` in the image; build it with the feature `stage-cost`, which keeps the stages apart")]
    NoFunction(String),
}

/// Pipeline refill of a taken branch [cycles]: one to three by the manual, and 1.5 from the
/// measured mixes.
const REFILL: f64 = 1.5;

/// Cycles of one instruction that does not branch.
const fn cycles(class: Class) -> f64 {
    match class {
        Class::FpDivide | Class::FpRoot => 14.0,
        Class::FpMultiplyAdd => 3.0,
        Class::IntegerDivide => 12.0, // two to twelve, ends early on small quotients
        // transfers: one cycle here, and one more for each word
        _ => 1.0,
    }
}

/// Cycles of an instruction by the same tables, without and with a jump.
#[must_use]
pub fn cycles_of(Instruction { class, words, .. }: Instruction) -> [f64; 2] {
    let straight = cycles(class) + f64::from(words);
    [straight, straight + REFILL]
}

const ALL: [Class; CLASSES] = [
    Class::FpLoad,
    Class::FpStore,
    Class::FpOp,
    Class::FpMultiplyAdd,
    Class::FpDivide,
    Class::FpRoot,
    Class::FpMove,
    Class::Load,
    Class::Store,
    Class::Branch,
    Class::Integer,
    Class::IntegerDivide,
    Class::System,
];

/// Instructions that one function executed, without those of its callees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Number of times that the function was entered.
    pub calls: u64,
    counts: [u64; CLASSES],
    words: u64,
    jumps: u64,
}

impl Cost {
    /// Instructions of one class.
    #[must_use]
    pub const fn count(&self, class: Class) -> u64 {
        self.counts[class as usize]
    }

    /// Number of instructions of all classes.
    #[must_use]
    pub fn instructions(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Estimated Cortex-M4F cycles, as described at the top of this module.
    #[must_use]
    pub fn cycles(&self) -> f64 {
        let own: f64 = ALL.iter().map(|class| self.count(*class) as f64 * cycles(*class)).sum();
        own + self.words as f64 + self.jumps as f64 * REFILL
    }

    fn add(&mut self, other: &Self) {
        self.calls += other.calls;
        for (mine, theirs) in self.counts.iter_mut().zip(other.counts) {
            *mine += theirs;
        }
        self.words += other.words;
        self.jumps += other.jumps;
    }
}

/// Costs by function of one call of the measured function and everything that it calls.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct InstructionMix {
    by_address: BTreeMap<u32, Cost>,
}

impl InstructionMix {
    /// Costs by function, in the order of their addresses.
    pub fn by_function<'a>(&'a self, image: &'a FirmwareImage) -> impl Iterator<Item = (&'a str, &'a Cost)> {
        self.by_address
            .iter()
            .map(|(address, cost)| (image.function_at(*address).map_or("(no symbol)", |f| f.name.as_str()), cost))
    }

    /// Sum over all functions.
    #[must_use]
    pub fn total(&self) -> Cost {
        let mut total = Cost::default();
        self.by_address.values().for_each(|cost| total.add(cost));
        total
    }

    fn of_function(&mut self, image: &FirmwareImage, address: u32) -> &mut Cost {
        self.by_address.entry(image.function_at(address).map_or(0, |f| f.address)).or_default()
    }

    /// Counts a jump by the previous instruction, which is known only once the next address is.
    fn note_jump(&mut self, image: &FirmwareImage, previous: Option<(u32, Instruction)>, address: u32) {
        if let Some((from, Instruction { class: Class::Branch | Class::Load, bytes, .. })) = previous
            && from + bytes != address
        {
            self.of_function(image, from).jumps += 1;
        }
    }

    fn note(&mut self, image: &FirmwareImage, previous: Option<(u32, Instruction)>, address: u32, instruction: Instruction) {
        let function = image.function_at(address);
        let at_entry = function.is_some_and(|f| f.address == address);
        let from_outside = previous.is_none_or(|(from, _)| image.function_at(from) != function);
        let cost = self.of_function(image, address);
        cost.calls += u64::from(at_entry && from_outside);
        cost.counts[instruction.class as usize] += 1;
        cost.words += u64::from(instruction.words);
    }
}

/// Returns one entry for every completed call of `function` in the log, in order: the instructions
/// that the call executed, those of its callees included.
pub fn calls_of(
    function: &str,
    image: &FirmwareImage,
    log: impl Iterator<Item = Result<u32, LogError>>,
) -> Result<Vec<InstructionMix>, MixError> {
    let entry = image.function_named(function).ok_or_else(|| MixError::NoFunction(function.into()))?.address;
    let mut calls = Vec::new();
    let mut open: Option<(u32, InstructionMix)> = None; // return address
    let mut previous: Option<(u32, Instruction)> = None;
    for address in log {
        let address = address?;
        let instruction = instruction_at(image, address)?;
        if let Some((return_address, mix)) = &mut open {
            mix.note_jump(image, previous, address);
            if address == *return_address {
                calls.extend(open.take().map(|(_, mix)| mix));
            }
        }
        let call = previous.filter(|(_, instruction)| instruction.calls);
        if let (true, None, Some((caller, Instruction { bytes, .. }))) = (address == entry, &open, call) {
            open = Some((caller + bytes, InstructionMix::default()));
        }
        if let Some((_, mix)) = &mut open {
            mix.note(image, previous, address, instruction);
        }
        previous = Some((address, instruction));
    }
    Ok(calls)
}

fn instruction_at(image: &FirmwareImage, address: u32) -> Result<Instruction, MixError> {
    let first = image.halfword_at(address).ok_or(MixError::NoCode(address))?;
    let second = image.halfword_at(address + 2).unwrap_or(0);
    classify(first, second).ok_or(MixError::UnknownOpcode { address, first, second })
}

#[cfg(test)]
mod tests {
    use super::{Cost, cycles};
    use crate::thumb::{Class, classify};

    /// Cycles of a straight-line sequence of instructions, each given by its encoding.
    fn estimate(codes: &[u32]) -> f64 {
        let mut cost = Cost::default();
        for code in codes {
            let (first, second) = if *code > 0xFFFF { ((code >> 16) as u16, *code as u16) } else { (*code as u16, 0) };
            let instruction = classify(first, second).unwrap();
            cost.counts[instruction.class as usize] += 1;
            cost.words += u64::from(instruction.words);
        }
        cost.cycles()
    }

    #[test]
    fn cycles_follow_the_reference_manual() {
        assert_eq!(estimate(&[0xED90_0A00]), 2.0); // vldr
        assert_eq!(estimate(&[0xECB0_0A03]), 4.0); // vldmia of 3: 1 + n
        assert_eq!(estimate(&[0xEE30_0A21, 0xEE20_0A21]), 2.0); // vadd, vmul
        assert_eq!(estimate(&[0xEE00_0A21]), 3.0); // vmla
        assert_eq!(estimate(&[0xEEC0_7A27, 0xEEB1_0AC0]), 28.0); // vdiv, vsqrt
        assert_eq!(estimate(&[0x6800, 0x1840]), 3.0); // ldr, adds
        assert_eq!(estimate(&[0xE92D_4FF0]), 10.0); // push of 9
        assert_eq!(estimate(&[0xEC51_0B10, 0xEE00_0A10]), 3.0); // vmov of two registers, of one
    }

    #[test]
    fn a_taken_branch_costs_the_refill() {
        let mut cost = Cost::default();
        cost.counts[Class::Branch as usize] = 2;
        cost.jumps = 1;
        assert_eq!(cost.cycles(), 2.0 * cycles(Class::Branch) + 1.5);
    }
}
