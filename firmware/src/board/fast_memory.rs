//! Copies code and patch at the start into memory that the core reads without wait states, if the
//! chip has any. `build/memory.rs` places them there.

use core::arch::asm;

unsafe extern "C" {
    static __fast_code_start: u32;
    static __fast_code_end: u32;
    static __fast_code_load: u32;
    static __patch_start: u32;
    static __patch_end: u32;
    static __patch_load: u32;
    static __large_start: u32;
    static __large_end: u32;
}

/// Fills the fast memories and clears the large one. Must run first, since neither tick nor patch
/// is in place before.
pub fn load() {
    copy(&raw const __fast_code_load, &raw const __fast_code_start, &raw const __fast_code_end);
    copy(&raw const __patch_load, &raw const __patch_start, &raw const __patch_end);
    clear(&raw const __large_start, &raw const __large_end);
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Copies words. Written in assembly, because a Cortex-M7 has its code memory at address 0, where
/// no Rust pointer may write.
fn copy(from: *const u32, to: *const u32, end: *const u32) {
    // SAFETY: the words between the linker's symbols have not been read yet.
    unsafe {
        asm!(
            "2:", "cmp {to}, {end}", "bhs 3f", "ldr {word}, [{from}], #4", "str {word}, [{to}], #4", "b 2b", "3:",
            from = inout(reg) from => _, to = inout(reg) to => _, end = in(reg) end, word = out(reg) _,
        );
    }
}

/// Clears words: memory with error correction must be written before it is read.
fn clear(from: *const u32, end: *const u32) {
    // SAFETY: as above.
    unsafe {
        asm!(
            "2:", "cmp {to}, {end}", "bhs 3f", "str {zero}, [{to}], #4", "b 2b", "3:",
            to = inout(reg) from => _, end = in(reg) end, zero = in(reg) 0,
        );
    }
}
