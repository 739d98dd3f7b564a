//! How often crashes have reset the board, in RAM that start-up does not clear and a reset does not
//! touch.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

use palpate_controller::resets::{Cause, Resets};

/// Marks a reset by the program, not by power-on.
const CRASHED: u32 = 0xC4A5_4ED0;

// SAFETY: nothing else is put into this section; the names are unique.
#[unsafe(link_section = ".uninit.resets")]
static mut RESETS: MaybeUninit<Resets> = MaybeUninit::uninit();
// SAFETY: as above.
#[unsafe(link_section = ".uninit.cause")]
static mut CAUSE: MaybeUninit<u32> = MaybeUninit::uninit();

static STARTED: AtomicBool = AtomicBool::new(false);
static BARRED: AtomicBool = AtomicBool::new(false);
static AFTER_CRASH: AtomicBool = AtomicBool::new(false);

/// Whether crashes came too often. The first call counts this start; it comes from `main`, before
/// anything else runs. `by_watchdog`: the watchdog has reset the board.
pub fn barred(by_watchdog: bool) -> bool {
    if !STARTED.swap(true, Ordering::Relaxed) {
        // SAFETY: every bit pattern is a `u32`, and a `Resets` of nothing but integers; nothing
        // else runs yet.
        let (resets, cause) = unsafe { (&mut *(&raw mut RESETS).cast::<Resets>(), &mut *(&raw mut CAUSE).cast::<u32>()) };
        let cause = if core::mem::take(cause) == CRASHED || by_watchdog { Cause::Crash } else { Cause::Power };
        BARRED.store(resets.start(cause), Ordering::Relaxed);
        AFTER_CRASH.store(cause == Cause::Crash, Ordering::Relaxed);
    }
    BARRED.load(Ordering::Relaxed)
}

/// Whether a crash caused this start, once it was counted.
pub fn crashed() -> bool {
    AFTER_CRASH.load(Ordering::Relaxed)
}

/// A tick has passed.
pub fn count_millisecond() {
    // SAFETY: from the haptic loop alone, after `barred` has made it a `Resets`.
    unsafe { (*(&raw mut RESETS).cast::<Resets>()).count() };
}

/// Resets the board as its watchdog would.
#[cfg(feature = "mps2")]
pub fn restart() -> ! {
    // SAFETY: interrupts are off, so nothing else runs.
    unsafe { (&raw mut CAUSE).cast::<u32>().write_volatile(CRASHED) };
    cortex_m::peripheral::SCB::sys_reset()
}
