//! Crashes of the image that is flashed. Before the board's clock runs, a debugger overwrites the
//! start of one function with a branch to a few instructions placed outside the image. They count
//! the passes and crash at a chosen one. The clock is never stopped, and the image contains no test
//! code.

use std::io;

use crate::debugger::Debugger;
use crate::firmware_image::FirmwareImage;

/// Address of the counting instructions, behind the image in its code memory.
const BESIDE: u32 = 0x0030_0000;
/// Address of the instructions that crash.
pub const CRASH: u32 = BESIDE + 0x100;
/// Address of the location that a panic reports.
const LOCATION: u32 = BESIDE + 0x1C0;
/// Address of the number of passes left before the crash.
const COUNTER: u32 = BESIDE + 0x1F0;
/// File name that a panic reports.
pub const FILE: &str = "debugger";

/// The register of the enable line.
const LEDS: u32 = 0x4002_8000;
const TIMER0_CTRL: u32 = 0x4000_0000;
const NVIC_ENABLE: u32 = 0xE000_E100;
const NVIC_PEND: u32 = 0xE000_E200;
/// An address at which the emulated boards have no memory.
const NOWHERE: u32 = 0x6000_0000;
/// An interrupt without a handler.
const STRAY: u32 = 20;

// Thumb instructions.
const PUSH_R0_R1: u16 = 0xB403;
const POP_R0_R1: u16 = 0xBC03;
/// `ldr r1, [r0]` and `str r1, [r0]`.
const LOAD_PASSES: u16 = 0x6801;
const STORE: u16 = 0x6001;
const COUNT_R1_DOWN: u16 = 0x3901;
const IF_NOT_ZERO: u16 = 0xD100;
/// `ldr r1, [sp, #36]`, the stacked xPSR above two words of our own; `lsls r1, r1, #23`, which
/// keeps its exception number; `str r0, [sp, #24]`, the stacked return address.
const LOAD_STACKED_MODE: u16 = 0x9909;
const KEEP_EXCEPTION_NUMBER: u16 = 0x05C9;
const STORE_RETURN_ADDRESS: u16 = 0x9006;
/// `ldr r0, [r0]`, `bx r0`, `bx r2`, `bx r12`, branch to itself.
const LOAD: u16 = 0x6800;
const GO_TO_R0: u16 = 0x4700;
const GO_TO_R2: u16 = 0x4710;
const GO_TO_R12: u16 = 0x4760;
const FOREVER: u16 = 0xE7FE;

/// Code in which the crash happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The haptic loop, before its tick.
    Tick,
    /// The tick timer's interrupt.
    Timer,
    /// Thread mode, which every interrupt preempts.
    Thread,
}

/// Failure to provoke, with the enable line on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crash {
    /// Calls a panic.
    Panics,
    /// Reads from an unmapped address.
    ReadsNowhere,
    /// Executes a word that is not an instruction.
    RunsNoInstruction,
    /// Jumps to an even address, which is not Thumb code.
    JumpsNowhere,
    /// Recurses without end.
    OverflowsTheStack,
    /// Sets an interrupt pending that has no handler.
    PendsAStrayInterrupt,
    /// Loops without end.
    Hangs,
    /// Stops the tick timer, then loops without end.
    StopsTheTimer,
    /// Does not crash: runs this many turns of a loop of two instructions, then continues normally.
    Dawdles(u32),
}

/// A crash to plant in an image.
#[derive(Clone, Copy, Debug)]
pub struct Planned {
    /// Code in which the crash happens.
    pub place: Place,
    /// Number of the pass at which the crash happens, counted from the start of the board.
    pub pass: u32,
    /// Failure to provoke.
    pub crash: Crash,
    /// Number of consecutive starts of the board in which the crash is planted.
    pub starts: u32,
}

/// Plants the crash in a board that has not started yet and starts the board. Does so again after
/// each reset, because the emulator then loads the image anew.
pub fn plant(debugger: &mut Debugger, image: &FirmwareImage, planned: &Planned) -> io::Result<()> {
    let main = image.function_named("palpate_firmware::__cortex_m_rt_main").map(|main| main.address);
    let main = main.ok_or_else(|| io::Error::other("the image has no main"))?;
    for _ in 0..planned.starts {
        // no timer runs yet, so a stop here does not affect the board's clock
        debugger.run_to(main)?;
        write(debugger, image, planned)?;
    }
    Ok(())
}

fn write(debugger: &mut Debugger, image: &FirmwareImage, planned: &Planned) -> io::Result<()> {
    let missing = |name: &str| io::Error::other(format!("the image has no function {name}"));
    let named = |part: &str, end: &str| {
        let found = image.functions().iter().find(|f| f.name.contains(part) && f.name.ends_with(end));
        found.map(|f| f.address).ok_or_else(|| missing(part))
    };
    let vectors = debugger.read(0, 16 + 32)?;
    let vector = |interrupt: usize| vectors.get(16 + interrupt).map(|v| v & !1).ok_or_else(|| missing("vector"));
    let address = match planned.place {
        Place::Tick => named("HapticLoop", "::answer")?,
        Place::Timer => vector(8)?,
        Place::Thread => vector(30)?,
    };
    let first = debugger.read(address & !3, 2)?;
    let first: Vec<u16> =
        first.iter().flat_map(|word| [*word as u16, (word >> 16) as u16]).skip((address & 2) as usize / 2).collect();
    let [first, second, ..] = first[..] else { return Err(missing("start")) };
    // `push.w`, or `push` and `add r7, sp`: position-independent, so they can be moved
    if first != 0xE92D && (first & 0xFF00 != 0xB500 || second & 0xFF00 != 0xAF00) {
        return Err(io::Error::other(format!("{address:#x} begins with {first:04x} {second:04x}, which cannot be moved")));
    }
    let trampoline = trampoline(planned, [first, second], address + 4);
    let displaced = BESIDE + 2 * trampoline.displaced as u32;
    debugger.write(BESIDE, &bytes(&trampoline.code))?;
    debugger.write(CRASH, &bytes(&code(planned.crash, named("panic_const_async_fn_resumed", "")?, displaced)))?;
    debugger.write(COUNTER, &planned.pass.to_le_bytes())?;
    let location = [LOCATION + 16, FILE.len() as u32 + 1, 1, 1].map(u32::to_le_bytes).concat();
    debugger.write(LOCATION, &[location, FILE.bytes().chain([0]).collect()].concat())?;
    debugger.write(address, &bytes(&branch(address, BESIDE)))
}

/// Whether an executed instruction belongs to the crash.
pub fn is_of_crash(address: u32) -> bool {
    (CRASH..LOCATION).contains(&address)
}

struct Trampoline {
    code: Vec<u16>,
    /// Position of the displaced instructions in `code` [halfwords].
    displaced: usize,
}

/// Code that counts a pass. At the planned pass it continues in the crash; otherwise it runs the
/// `displaced` instructions and returns to the code behind them, at `back`.
fn trampoline(planned: &Planned, displaced: [u16; 2], back: u32) -> Trampoline {
    let thread = planned.place == Place::Thread;
    // this code runs in an interrupt of the thread: it changes the return address to the crash
    let hit = match thread {
        true => [&load(0, CRASH)[..], &[STORE_RETURN_ADDRESS]].concat(),
        false => [&load(12, CRASH | 1)[..], &[GO_TO_R12]].concat(),
    };
    let armed = [&[POP_R0_R1], &hit[..]].concat();
    // skips the pop of the other branch
    let armed = if thread { [&armed[..], &[0xE000]].concat() } else { armed };
    let count = [&load(0, COUNTER)[..], &[LOAD_PASSES, COUNT_R1_DOWN, STORE, skip(IF_NOT_ZERO, armed.len())]].concat();
    let rest = [&count[..], &armed].concat();
    let in_thread = match thread {
        true => vec![LOAD_STACKED_MODE, KEEP_EXCEPTION_NUMBER, skip(IF_NOT_ZERO, rest.len())],
        false => Vec::new(),
    };
    let mut code = [&[PUSH_R0_R1], &in_thread[..], &rest, &[POP_R0_R1]].concat();
    let place = code.len();
    code.extend([&displaced[..], &load(12, back | 1), &[GO_TO_R12]].concat());
    Trampoline { code, displaced: place }
}

/// Conditional branch that skips this many halfwords.
fn skip(condition: u16, halfwords: usize) -> u16 {
    condition | (halfwords as u16 - 1) & 0xFF
}

/// `b.w` to a higher address.
fn branch(from: u32, to: u32) -> [u16; 2] {
    let offset = to.wrapping_sub(from + 4);
    let (high, low) = ((offset >> 12 & 0x3FF) as u16, (offset >> 1 & 0x7FF) as u16);
    // bits 23 and 22 of a forward branch below 4 MB are zero, so both J bits are set
    [0xF000 | high, 0xB800 | low]
}

fn code(crash: Crash, panic: u32, displaced: u32) -> Vec<u16> {
    let enable = [&load(0, LEDS)[..], &load(1, 1), &[STORE]].concat();
    let broken = match crash {
        Crash::Panics => [&load(0, LOCATION)[..], &load(2, panic | 1), &[GO_TO_R2]].concat(),
        Crash::ReadsNowhere => [&load(0, NOWHERE)[..], &[LOAD]].concat(),
        Crash::RunsNoInstruction => vec![0xDE00],
        Crash::JumpsNowhere => [&load(0, 0x1000)[..], &[GO_TO_R0]].concat(),
        // sub sp, #508; push {r0}; ldr r1, [sp]; bx r1: continues as long as the stack retains the
        // address
        Crash::OverflowsTheStack => {
            let turn = CRASH + 2 * (enable.len() as u32 + 4);
            [&load(0, turn | 1)[..], &[0xB0FF, 0xB401, 0x9900, 0x4708]].concat()
        }
        Crash::PendsAStrayInterrupt => {
            let pend = |register| [&load(0, register)[..], &load(1, 1 << STRAY), &[STORE]].concat();
            [&pend(NVIC_ENABLE)[..], &pend(NVIC_PEND), &[FOREVER]].concat()
        }
        Crash::Hangs => vec![FOREVER],
        Crash::StopsTheTimer => [&load(0, TIMER0_CTRL)[..], &load(1, 0), &[STORE, FOREVER]].concat(),
        // r12 is free at the start of a function; subs.w, bne back
        Crash::Dawdles(turns) => {
            return [&load(12, turns)[..], &[0xF1BC, 0x0C01, 0xD1FC], &load(12, displaced | 1), &[GO_TO_R12]].concat();
        }
    };
    [enable, broken].concat()
}

fn bytes(code: &[u16]) -> Vec<u8> {
    code.iter().flat_map(|half| half.to_le_bytes()).collect()
}

/// `movw` and `movt`: load a 32-bit value into a register.
fn load(register: u16, value: u32) -> [u16; 4] {
    let half = |opcode: u16, half: u16| {
        let (imm4, i, imm3, imm8) = (half >> 12, half >> 11 & 1, half >> 8 & 7, half & 0xFF);
        [opcode | i << 10 | imm4, imm3 << 12 | register << 8 | imm8]
    };
    let ([a, b], [c, d]) = (half(0xF240, value as u16), half(0xF2C0, (value >> 16) as u16));
    [a, b, c, d]
}

#[cfg(test)]
mod tests {
    use super::{branch, load};

    #[test]
    fn a_value_is_loaded_by_its_halves() {
        // movw r0, #0x8000; movt r0, #0x4002, as the assembler encodes them
        assert_eq!(load(0, 0x4002_8000), [0xF248, 0x0000, 0xF2C4, 0x0002]);
        assert_eq!(load(12, 0x1234_5678), [0xF245, 0x6C78, 0xF2C1, 0x2C34]);
    }

    #[test]
    fn a_branch_counts_from_four_bytes_behind_itself() {
        // b.w with offset 0, and with 0x2fd1ee
        assert_eq!(branch(0x1000, 0x1004), [0xF000, 0xB800]);
        assert_eq!(branch(0x2E0E, 0x0030_0000), [0xF2FD, 0xB8F7]);
    }
}
