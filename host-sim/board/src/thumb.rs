//! Sorts Thumb-2 instructions into classes that differ in cost on a Cortex-M4F.
//!
//! Encodings: Arm DDI 0403E (`ARMv7-M` architecture reference manual), chapters A5 and A6; every
//! mask names its section. `FPv5` and double-precision encodings are sorted too, so that an image
//! built for the Cortex-M7 can be read.

/// Classes of instructions with equal cost. Transferred words are counted separately.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// `vldr`, `vldm`, `vpop`
    FpLoad,
    /// `vstr`, `vstm`, `vpush`
    FpStore,
    /// `vadd vsub vmul vnmul vneg vabs vcmp vcvt`, `vmov` of a register or a constant
    FpOp,
    /// `vmla vmls vnmla vnmls vfma vfms vfnma vfnms`
    FpMultiplyAdd,
    /// `vdiv`
    FpDivide,
    /// `vsqrt`
    FpRoot,
    /// `vmov` between the register files, `vmrs`, `vmsr`
    FpMove,
    /// `ldr*`, `ldm`, `ldrd`, `pop`
    Load,
    /// `str*`, `stm`, `strd`, `push`
    Store,
    /// `b`, `bl`, `bx`, `cbz`, `tbb`, writes to the program counter
    Branch,
    /// Everything that computes on core registers, multiplication and `it` included
    Integer,
    /// `sdiv`, `udiv`
    IntegerDivide,
    /// Barriers, hints, special registers, `bkpt`, `svc`
    System,
}

/// Number of [`Class`]es.
pub const CLASSES: usize = Class::System as usize + 1;

/// Properties of an instruction that determine its cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// Class of the instruction.
    pub class: Class,
    /// Length [bytes]: 2 or 4.
    pub bytes: u32,
    /// Cycles in addition to those of the class: one for every 32-bit word to or from memory, and
    /// one for a second register that is moved.
    pub words: u32,
    /// Whether the instruction leaves a return address in `lr`.
    pub calls: bool,
}

impl Instruction {
    const fn of(class: Class, words: u32) -> Self {
        Self { class, bytes: 2, words, calls: false }
    }
}

/// Whether a first halfword begins a 32-bit instruction (A5.1).
#[must_use]
pub const fn is_wide(first: u16) -> bool {
    first >> 11 >= 0b11101
}

/// Sorts the instruction in `first` and, if [`is_wide`], `second`. Returns `None` if the encoding
/// is not in this table.
#[must_use]
pub fn classify(first: u16, second: u16) -> Option<Instruction> {
    if is_wide(first) {
        let instruction = if first & 0xEC00 == 0xEC00 { coprocessor(first, second) } else { wide(first, second) };
        instruction.map(|i| Instruction { bytes: 4, calls: first >> 11 == 0b11110 && second & 0xD000 == 0xD000, ..i })
    } else {
        // blx register (A7.7.19)
        Some(Instruction { calls: first & 0xFF80 == 0x4780, ..narrow(first) })
    }
}

/// A5.2: 16-bit instructions.
fn narrow(op: u16) -> Instruction {
    use Class::{Branch, Integer, Load, Store, System};
    let list = u32::from(op & 0xFF).count_ones();
    let load_bit = if op & 0x0800 == 0 { Store } else { Load };
    match op >> 12 {
        0b0000..=0b0011 => Instruction::of(Integer, 0),
        0b0100 => match (op >> 10) & 0b11 {
            0b00 => Instruction::of(Integer, 0),
            // A5.2.3: add, cmp, mov on any register, bx, blx
            0b01 => {
                let destination = (op >> 4 & 0b1000) | (op & 0b111);
                let compares = op & 0x0300 == 0x0100;
                let jumps = op & 0x0300 == 0x0300 || (destination == 15 && !compares);
                Instruction::of(if jumps { Branch } else { Integer }, 0)
            }
            _ => Instruction::of(Load, 1), // literal
        },
        // A5.2.4: str strh strb ldrsb ldr ldrh ldrb ldrsh, register offset
        0b0101 => Instruction::of(if op >> 9 & 0b111 < 0b011 { Store } else { Load }, 1),
        0b0110..=0b1001 => Instruction::of(load_bit, 1),
        0b1010 => Instruction::of(Integer, 0), // adr, add to sp
        0b1011 => miscellaneous(op),
        0b1100 => Instruction::of(load_bit, list),
        0b1101 => Instruction::of(if op >> 9 & 0b111 == 0b111 { System } else { Branch }, 0), // udf, svc
        _ => Instruction::of(Branch, 0),
    }
}

/// A5.2.5: miscellaneous 16-bit instructions.
fn miscellaneous(op: u16) -> Instruction {
    use Class::{Branch, Integer, Load, Store, System};
    let list = u32::from(op & 0x01FF).count_ones(); // bit 8 is lr or pc
    match op >> 8 & 0xF {
        0b0001 | 0b0011 | 0b1001 | 0b1011 => Instruction::of(Branch, 0), // cbz, cbnz
        0b0100 | 0b0101 => Instruction::of(Store, list),
        0b1100 | 0b1101 => Instruction::of(Load, list),
        0b0110 | 0b1110 => Instruction::of(System, 0),         // cps, bkpt
        0b1111 if op & 0xF == 0 => Instruction::of(System, 0), // nop, wfi and other hints
        _ => Instruction::of(Integer, 0),
    }
}

/// A5.3: 32-bit instructions outside the coprocessor space.
fn wide(first: u16, second: u16) -> Option<Instruction> {
    use Class::{Branch, Integer, IntegerDivide, Load, Store, System};
    let loads = first & 0x0010 != 0;
    let transfer = if loads { Load } else { Store };
    Some(match first >> 9 {
        // A5.3.5: ldm, stm
        0b111_0100 if first & 0x0040 == 0 => Instruction::of(transfer, u32::from(second).count_ones()),
        // A5.3.6: dual, exclusive, table branch
        0b111_0100 => {
            let dual = first & 0x0120 != 0;
            let table = first & 0xFFF0 == 0xE8D0 && second & 0x00E0 == 0;
            if table { Instruction::of(Branch, 0) } else { Instruction::of(transfer, if dual { 2 } else { 1 }) }
        }
        // A5.3.11: shifted register; A5.3.1, A5.3.3: immediates
        0b111_0101 => Instruction::of(Integer, 0),
        0b111_1000..=0b111_1011 if second & 0x8000 == 0 => Instruction::of(Integer, 0),
        // A5.3.4: branches, special registers, barriers, hints
        0b111_1000..=0b111_1011 => {
            let conditional_or_system = second & 0x5000 == 0;
            let system = conditional_or_system && first >> 7 & 0b111 == 0b111;
            Instruction::of(if system { System } else { Branch }, 0)
        }
        // A5.3.7 to A5.3.10: single transfers; a byte or halfword "loaded" to pc is a preload hint
        0b111_1100 => {
            let to_pc = loads && second >> 12 == 15;
            let word = first >> 5 & 0b11 == 0b10;
            match (to_pc, word) {
                (true, false) => Instruction::of(System, 0),
                _ => Instruction::of(transfer, 1),
            }
        }
        // A5.3.12 to A5.3.16: register, multiply; A5.3.17: long multiply and divide
        0b111_1101 => {
            let divides = first & 0xFFD0 == 0xFB90 && second & 0x00F0 == 0x00F0;
            Instruction::of(if divides { IntegerDivide } else { Integer }, 0)
        }
        _ => return None,
    })
}

/// A5.3.18, A6.4 to A6.7: the floating-point extension, coprocessors 10 (single) and 11 (double).
fn coprocessor(first: u16, second: u16) -> Option<Instruction> {
    use Class::{FpDivide, FpLoad, FpMove, FpMultiplyAdd, FpOp, FpRoot, FpStore};
    if second & 0x0E00 != 0x0A00 {
        return None;
    }
    let double = second & 0x0100 != 0;
    // A6.5: transfers to and from memory, and of two core registers
    if first & 0xFE00 == 0xEC00 {
        if first & 0xFFE0 == 0xEC40 {
            return Some(Instruction::of(FpMove, 1));
        }
        let class = if first & 0x0010 == 0 { FpStore } else { FpLoad };
        let single_register = first & 0x0120 == 0x0100;
        let words = match (single_register, double) {
            (true, false) => 1,
            (true, true) => 2,
            (false, _) => u32::from(second & 0xFF),
        };
        return Some(Instruction::of(class, words));
    }
    // FPv5: vsel, vmaxnm, vminnm, vrint, vcvt with rounding
    if first & 0xFF00 == 0xFE00 {
        return Some(Instruction::of(FpOp, 0));
    }
    if first & 0xFF00 != 0xEE00 {
        return None;
    }
    // A6.6: one core register
    if second & 0x0010 != 0 {
        return Some(Instruction::of(FpMove, 0));
    }
    // A6.4: arithmetic; bit 6 of the first halfword belongs to a register number
    let variant = second & 0x0040 != 0;
    let class = match first >> 4 & 0b1011 {
        0b0000 | 0b0001 | 0b1001 | 0b1010 => FpMultiplyAdd,
        0b0010 | 0b0011 => FpOp,
        0b1000 if !variant => FpDivide,
        0b1011 if first & 0xF == 0b0001 && second & 0x00C0 == 0x00C0 => FpRoot,
        0b1011 => FpOp,
        _ => return None,
    };
    Some(Instruction::of(class, 0))
}

#[cfg(test)]
mod tests {
    use super::{Class, Instruction, classify, is_wide};

    /// Class, transferred words and length of an instruction given as one number, with its first
    /// halfword in the upper half.
    fn sorted(code: u32) -> (Class, u32, u32) {
        let halves = if code > 0xFFFF { ((code >> 16) as u16, code as u16) } else { (code as u16, 0) };
        assert_eq!(is_wide(halves.0), code > 0xFFFF);
        let Some(Instruction { class, bytes, words, .. }) = classify(halves.0, halves.1) else { panic!("{code:#x} is unknown") };
        (class, words, bytes)
    }

    #[test]
    fn floating_point_encodings() {
        for (code, class, words) in [
            (0xED90_0A00, Class::FpLoad, 1),        // vldr s0, [r0]
            (0xED90_0B00, Class::FpLoad, 2),        // vldr d0, [r0]
            (0xEDC1_7A02, Class::FpStore, 1),       // vstr s15, [r1, #8]
            (0xECB0_0A03, Class::FpLoad, 3),        // vldmia r0!, {s0-s2}
            (0xED2D_8B10, Class::FpStore, 16),      // vpush {d8-d15}
            (0xECBD_8B10, Class::FpLoad, 16),       // vpop {d8-d15}
            (0xEE30_0A21, Class::FpOp, 0),          // vadd.f32 s0, s0, s3
            (0xEE30_0A61, Class::FpOp, 0),          // vsub.f32 s0, s0, s3
            (0xEE20_0A21, Class::FpOp, 0),          // vmul.f32 s0, s0, s3
            (0xEE20_0A61, Class::FpOp, 0),          // vnmul.f32 s0, s0, s3
            (0xEEB1_0A40, Class::FpOp, 0),          // vneg.f32 s0, s0
            (0xEEB0_0AC0, Class::FpOp, 0),          // vabs.f32 s0, s0
            (0xEEB0_0A60, Class::FpOp, 0),          // vmov.f32 s0, s1
            (0xEEB7_0A00, Class::FpOp, 0),          // vmov.f32 s0, #1.0
            (0xEEB4_0A60, Class::FpOp, 0),          // vcmp.f32 s0, s1
            (0xEEB8_0AC0, Class::FpOp, 0),          // vcvt.f32.s32 s0, s0
            (0xEE00_0A21, Class::FpMultiplyAdd, 0), // vmla.f32 s0, s0, s3
            (0xEE00_0A61, Class::FpMultiplyAdd, 0), // vmls.f32 s0, s0, s3
            (0xEEA0_0A21, Class::FpMultiplyAdd, 0), // vfma.f32 s0, s0, s3
            (0xEE90_0A21, Class::FpMultiplyAdd, 0), // vfnms.f32 s0, s0, s3
            (0xEEC0_7A27, Class::FpDivide, 0),      // vdiv.f32 s15, s0, s15
            (0xEEB1_0AC0, Class::FpRoot, 0),        // vsqrt.f32 s0, s0
            (0xEEF1_FA10, Class::FpMove, 0),        // vmrs APSR_nzcv, fpscr
            (0xEE00_0A10, Class::FpMove, 0),        // vmov s0, r0
            (0xEC51_0B10, Class::FpMove, 1),        // vmov r0, r1, d0
            (0xFE00_0A00, Class::FpOp, 0),          // vseleq.f32 s0, s0, s0
        ] {
            assert_eq!(sorted(code), (class, words, 4), "{code:#x}");
        }
    }

    #[test]
    fn transfers_and_branches() {
        for (code, class, words) in [
            (0x6800, Class::Load, 1),        // ldr r0, [r0]
            (0x6008, Class::Store, 1),       // str r0, [r1]
            (0x5E88, Class::Load, 1),        // ldrsh r0, [r1, r2]
            (0x5488, Class::Store, 1),       // strb r0, [r1, r2]
            (0x4801, Class::Load, 1),        // ldr r0, [pc, #4]
            (0xB580, Class::Store, 2),       // push {r7, lr}
            (0xBD80, Class::Load, 2),        // pop {r7, pc}
            (0xC903, Class::Load, 2),        // ldm r1!, {r0, r1}
            (0xE92D_4FF0, Class::Store, 9),  // push {r4-r11, lr}
            (0xE8BD_8FF0, Class::Load, 9),   // pop {r4-r11, pc}
            (0xE9D0_0100, Class::Load, 2),   // ldrd r0, r1, [r0]
            (0xE9C0_0100, Class::Store, 2),  // strd r0, r1, [r0]
            (0xE850_0F00, Class::Load, 1),   // ldrex r0, [r0]
            (0xE8DF_F001, Class::Branch, 0), // tbb [pc, r1]
            (0xF8D0_0100, Class::Load, 1),   // ldr.w r0, [r0, #256]
            (0xF8C0_0100, Class::Store, 1),  // str.w r0, [r0, #256]
            (0xF810_F000, Class::System, 0), // pld [r0, r0]
            (0xD1FE, Class::Branch, 0),      // bne .
            (0xE7FE, Class::Branch, 0),      // b .
            (0xB108, Class::Branch, 0),      // cbz r0, .+2
            (0x4770, Class::Branch, 0),      // bx lr
            (0x4780, Class::Branch, 0),      // blx r0
            (0x4687, Class::Branch, 0),      // mov pc, r0
            (0xF7FF_FFFE, Class::Branch, 0), // bl .
            (0xF000_8000, Class::Branch, 0), // beq.w
        ] {
            let bytes = if code > 0xFFFF { 4 } else { 2 };
            assert_eq!(sorted(code), (class, words, bytes), "{code:#x}");
        }
    }

    #[test]
    fn integer_and_system_encodings() {
        for (code, class) in [
            (0x1840, Class::Integer),            // adds r0, r0, r1
            (0x4348, Class::Integer),            // muls r0, r1, r0
            (0x4587, Class::Integer),            // cmp pc, r0 writes no register
            (0xBF08, Class::Integer),            // it eq
            (0xB240, Class::Integer),            // sxtb r0, r0
            (0xEB00_0001, Class::Integer),       // add.w r0, r0, r1
            (0xF100_0001, Class::Integer),       // add.w r0, r0, #1
            (0xFBA0_0101, Class::Integer),       // umull r0, r1, r0, r1
            (0xFB90_F0F1, Class::IntegerDivide), // sdiv r0, r0, r1
            (0xFBB0_F0F1, Class::IntegerDivide), // udiv r0, r0, r1
            (0xBF00, Class::System),             // nop
            (0xBF30, Class::System),             // wfi
            (0xBEAB, Class::System),             // bkpt 0xab
            (0xB672, Class::System),             // cpsid i
            (0xF3BF_8F5F, Class::System),        // dmb sy
            (0xF3EF_8010, Class::System),        // mrs r0, primask
        ] {
            assert_eq!(sorted(code).0, class, "{code:#x}");
        }
    }

    #[test]
    fn only_linking_branches_are_calls() {
        let calls = |first, second| classify(first, second).is_some_and(|i| i.calls);
        assert!(calls(0xF7FF, 0xFFFE)); // bl .
        assert!(calls(0x4780, 0)); // blx r0
        assert!(!calls(0x4700, 0)); // bx r0
        assert!(!calls(0xF7FF, 0xBFFE)); // b.w .
    }
}
