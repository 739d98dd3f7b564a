//! Record of the last crash. A crash is reported by the next start, because the watchdog resets the
//! board within milliseconds.

use core::fmt;

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

/// Start of the sum over a record, so that memory of equal words is no record.
const MAGIC: u32 = 0xC4A5_0001;
/// Longest part of a source file's name that is kept, its end [bytes].
const FILE_BYTES: usize = 32;

/// Cause of the end of a program. All values are words, so that any content of memory is valid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct Crash {
    /// Number of the kind, one of the constants below.
    pub kind: u32,
    /// Address of the instruction of a hard fault.
    pub pc: u32,
    /// Address to which its function would have returned.
    pub lr: u32,
    /// Configurable fault status register (CFSR).
    pub cfsr: u32,
    /// Address of the data of a hard fault (BFAR), valid if `cfsr` says so.
    pub address: u32,
    /// Line of a panic, or number of an interrupt.
    pub line: u32,
    /// Source file of a panic, padded with zeros.
    pub file: [u8; FILE_BYTES],
}

impl Crash {
    const PANIC: u32 = 1;
    const HARD_FAULT: u32 = 2;
    const OVERFLOW: u32 = 3;
    const STRAY_INTERRUPT: u32 = 4;
    const HANG: u32 = 5;
    const NONE: Self = Self { kind: 0, pc: 0, lr: 0, cfsr: 0, address: 0, line: 0, file: [0; FILE_BYTES] };
    /// The stack overflowed.
    pub const STACK_OVERFLOW: Self = Self { kind: Self::OVERFLOW, ..Self::NONE };
    /// Ticks did not complete, and the watchdog acted.
    pub const HUNG: Self = Self { kind: Self::HANG, ..Self::NONE };

    /// A panic in this line of a source file.
    #[must_use]
    pub fn panic(name: &str, line: u32) -> Self {
        let mut file = [0; FILE_BYTES];
        // from the end, since the beginning of a path says least
        file.iter_mut().rev().zip(name.bytes().rev()).for_each(|(place, byte)| *place = byte);
        Self { kind: Self::PANIC, line, file, ..Self::NONE }
    }

    /// A hard fault with the registers that the core saved.
    #[must_use]
    pub fn hard_fault(pc: u32, lr: u32, cfsr: u32, address: u32) -> Self {
        Self { kind: Self::HARD_FAULT, pc, lr, cfsr, address, ..Self::NONE }
    }

    /// An interrupt of this number, which has no handler.
    #[must_use]
    pub fn stray_interrupt(number: u32) -> Self {
        Self { kind: Self::STRAY_INTERRUPT, line: number, ..Self::NONE }
    }
}

/// Bits of the fault status register, and what each reports.
const STATUS: [(u32, &str); 9] = [
    (0, "code outside the memories"),
    (1, "data outside the memories"),
    (8, "bus error in fetching an instruction"),
    (9, "bus error in accessing data"),
    (10, "bus error in writing data some instructions before"),
    (12, "bus error in saving registers"),
    (16, "no such instruction"),
    (17, "no Thumb code"),
    (24, "unaligned access"),
];
/// Bit that says that the address of the data is valid.
const ADDRESS_VALID: u32 = 15;

impl fmt::Display for Crash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pc, lr, cfsr, address, line, .. } = self;
        match self.kind {
            Self::PANIC => {
                let name = core::str::from_utf8(&self.file).unwrap_or_default();
                write!(f, "panic in line {line} of {}", name.trim_matches('\0'))
            }
            Self::HARD_FAULT => {
                let named = STATUS.iter().find(|(bit, _)| cfsr >> bit & 1 == 1);
                let why = named.map_or("the core gives no cause", |(_, why)| why);
                write!(f, "hard fault at {pc:#010x}, called from {lr:#010x}: {why}")?;
                if cfsr >> ADDRESS_VALID & 1 == 1 { write!(f, ", address {address:#010x}") } else { Ok(()) }
            }
            Self::OVERFLOW => f.write_str("the stack overflowed"),
            Self::STRAY_INTERRUPT => write!(f, "interrupt {line} has no handler"),
            Self::HANG => f.write_str("ticks did not complete, and the watchdog acted"),
            other => write!(f, "crash {other} (of another version than this palpate)"),
        }
    }
}

/// A crash in memory that keeps its content during a reset: 64 bytes.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct CrashRecord {
    crash: Crash,
    /// 1 until the start after the crash.
    fresh: u32,
    /// Sum of all fields above; after power-on it is wrong.
    check: u32,
}

impl CrashRecord {
    fn sum(&self) -> u32 {
        let words: &[u32; size_of::<Self>() / 4] = bytemuck::cast_ref(self);
        let (_, before) = words.split_last().unwrap_or((&0, &[]));
        before.iter().fold(MAGIC, |sum, word| sum.rotate_left(1) ^ word)
    }

    /// Keeps a crash for the next start.
    #[inline(never)]
    pub fn keep(&mut self, crash: &Crash) {
        (self.crash, self.fresh) = (*crash, 1);
        self.check = self.sum();
    }

    /// Records a start of the board. After a crash that has left no record, the watchdog has ended
    /// a hang.
    pub fn start(&mut self, after_crash: bool) {
        let known = self.last().is_some();
        if after_crash && !(known && self.fresh == 1) {
            self.keep(&Crash::HUNG);
        } else if !known {
            return;
        }
        self.fresh = 0;
        self.check = self.sum();
    }

    /// The last crash since power-on; `None` if there was none.
    #[must_use]
    pub fn last(&self) -> Option<Crash> {
        (self.check == self.sum()).then_some(self.crash)
    }
}

#[cfg(test)]
mod tests {
    use std::format;

    use super::*;

    #[test]
    fn a_crash_is_kept_over_resets_and_a_reset_without_one_was_a_hang() {
        for noise in [0, 1, 0xFFFF_FFFF, 0x2000_4A31_u32] {
            let mut record: CrashRecord = bytemuck::cast([noise; 16]);
            record.start(false);
            assert_eq!(record.last(), None, "memory after power-on, {noise:#x}");
            let crash = Crash::hard_fault(0x0800_1234, 0x0800_5678, 1 << 9 | 1 << 15, 0x6000_0000);
            record.keep(&crash);
            record.start(true);
            assert_eq!(record.last(), Some(crash));
            record.start(false);
            assert_eq!(record.last(), Some(crash), "the reset button does not clear it");
            record.start(true);
            assert_eq!(record.last(), Some(Crash::HUNG), "the record was of an earlier crash");
            for bit in 0..512 {
                let mut damaged: [u32; 16] = bytemuck::cast(record);
                damaged[bit / 32] ^= 1 << (bit % 32);
                assert_eq!(bytemuck::cast::<_, CrashRecord>(damaged).last(), None, "bit {bit}");
            }
        }
    }

    #[test]
    fn each_crash_is_a_sentence() {
        let fault = Crash::hard_fault(0x0800_1234, 0x0800_5678, 1 << 9 | 1 << 15, 0x6000_0000);
        let sentences = [
            (Crash::panic("controller/src/patch/contact.rs", 181), "panic in line 181 of controller/src/patch/contact.rs"),
            (Crash::panic("main.rs", 7), "panic in line 7 of main.rs"),
            (fault, "hard fault at 0x08001234, called from 0x08005678: bus error in accessing data, address 0x60000000"),
            (Crash::hard_fault(2, 3, 1 << 16, 9), "hard fault at 0x00000002, called from 0x00000003: no such instruction"),
            (Crash::STACK_OVERFLOW, "the stack overflowed"),
            (Crash::stray_interrupt(20), "interrupt 20 has no handler"),
            (Crash::HUNG, "ticks did not complete, and the watchdog acted"),
        ];
        for (crash, sentence) in sentences {
            assert_eq!(format!("{crash}"), sentence);
        }
    }
}
