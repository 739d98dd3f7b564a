//! Crashes that safe code cannot make, for `plant.rs`.

use core::arch::asm;

use cortex_m::{interrupt::InterruptNumber, peripheral::NVIC};

use super::TIMER0_CTRL;

/// An address behind which these images have nothing.
const NOWHERE: *const u32 = 0x6000_0000_u32 as *const u32;

/// An interrupt that nobody has claimed.
#[derive(Clone, Copy)]
struct Stray;

// SAFETY: number 20 is below the 32 interrupts these images have.
unsafe impl InterruptNumber for Stray {
    fn number(self) -> u16 {
        20
    }
}

#[inline(never)]
pub fn reads_nowhere() {
    // SAFETY: there is none: the bus fault is wanted.
    core::hint::black_box(unsafe { NOWHERE.read_volatile() });
}

#[inline(never)]
pub fn runs_an_undefined_instruction() {
    // SAFETY: there is none: the usage fault is wanted.
    unsafe { asm!("udf #0") }
}

#[inline(never)]
pub fn jumps_nowhere() {
    // SAFETY: there is none: an even address is no Thumb code, and the usage fault is wanted.
    unsafe { asm!("mov r0, #0x1000", "bx r0", out("r0") _) }
}

#[inline(never)]
pub fn pends_a_stray_interrupt() {
    // SAFETY: its handler is the default one, which is what is tried.
    unsafe { NVIC::unmask(Stray) };
    NVIC::pend(Stray);
    cortex_m::asm::isb();
}

/// The tick timer's interrupt no longer comes; the thread goes on. It stays awake, for the emulator's clock runs ahead of a core that sleeps.
#[inline(never)]
pub fn stops_the_timer() {
    // SAFETY: timer 0 belongs to this board.
    unsafe { TIMER0_CTRL.write_volatile(0) };
    loop {
        core::hint::black_box(());
    }
}
