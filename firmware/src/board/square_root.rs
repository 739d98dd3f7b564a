//! The C function for square roots, which compiled code calls for negative numbers only: for all
//! others it contains the instruction. The compiler's own function takes 500 bytes of flash.

use core::arch::naked_asm;

/// Square root; not-a-number for a negative number.
// SAFETY: name and arguments are those of the C library, and the linker takes the first definition
// that it finds. The calling convention passes the number and its root in s0.
#[unsafe(no_mangle)]
#[unsafe(naked)]
extern "C" fn sqrtf(_: f32) -> f32 {
    naked_asm!("vsqrt.f32 s0, s0", "bx lr")
}
