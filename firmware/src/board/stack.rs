//! The stack, which is below the statics (`memory.x`) and painted by cortex-m-rt, and the handler
//! of its overflow.

use palpate_controller::crash::Crash;

use super::{outputs_off, stop};

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Size of the stack below the statics, as set in `memory.x`.
pub const STACK_BYTES: usize = 16 * 1024;
/// Pattern with which cortex-m-rt's `paint-stack` fills the stack.
const PAINT: u32 = 0xCCCC_CCCC;

/// Largest stack use so far [bytes]: the part of the stack in which the paint is overwritten.
pub fn stack_used_bytes() -> usize {
    let (low, high) = (&raw const _stack_end, &raw const _stack_start);
    let words = (high.addr() - low.addr()) / size_of::<u32>();
    // SAFETY: both symbols come from `memory.x` and bound the stack; every word between them is
    // RAM, and reading one has no side effect.
    let untouched = (0..words).take_while(|at| unsafe { low.add(*at).read_volatile() } == PAINT).count();
    (words - untouched) * size_of::<u32>()
}

// A stack that overflowed has left RAM at its lower end. The report needs a valid stack, so the
// stack pointer is set back to the top.
core::arch::global_asm!(
    ".section .HardFault.palpate, \"ax\"",
    ".global HardFault",
    ".type HardFault,%function",
    ".thumb_func",
    "HardFault:",
    "cpsid i",
    "mov r0, sp",
    "ldr r1, =_stack_start",
    "mov sp, r1",
    "b {on_hard_fault}",
    ".size HardFault, . - HardFault",
    on_hard_fault = sym on_hard_fault,
);

/// `frame` is the address at which the core saved the registers of the failed code: eight words,
/// the seventh of which is the program counter. They are reported only if the address is within the
/// stack.
extern "C" fn on_hard_fault(frame: *const u32) -> ! {
    outputs_off();
    let stack = (&raw const _stack_end).addr()..(&raw const _stack_start).addr() - 32;
    if stack.contains(&frame.addr()) {
        // SAFETY: eight words from here on are within the stack.
        let [lr, pc] = unsafe { [frame.add(5).read_volatile(), frame.add(6).read_volatile()] };
        // SAFETY: registers of the core without side effects on reading.
        let scb = unsafe { &*cortex_m::peripheral::SCB::PTR };
        let crash = Crash::hard_fault(pc, lr, scb.cfsr.read(), scb.bfar.read());
        stop(&crash, format_args!("hard fault at pc={pc:#010x} lr={lr:#010x}"))
    }
    stop(&Crash::STACK_OVERFLOW, format_args!("hard fault: the stack overflowed"))
}

#[cortex_m_rt::exception]
unsafe fn DefaultHandler(irqn: i16) -> ! {
    stop(&Crash::stray_interrupt(irqn.cast_unsigned().into()), format_args!("interrupt {irqn} has no handler"))
}
