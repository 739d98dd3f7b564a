//! Records of the crashes that reset the board, in RAM that neither a reset nor start-up clears.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

use palpate_controller::crash::{Crash, CrashRecord};
use palpate_controller::resets::{Cause, Resets};

/// Marks a reset that the program made after a crash.
const CRASHED: u32 = 0xC4A5_4ED0;
/// Marks a reset that the program made to store a profile.
const RESTARTED: u32 = 0x4E57_A47E;

// SAFETY: nothing else is put into this section; the names are unique.
#[unsafe(link_section = ".uninit.resets")]
static mut RESETS: MaybeUninit<Resets> = MaybeUninit::uninit();
// SAFETY: as above.
#[unsafe(link_section = ".uninit.cause")]
static mut CAUSE: MaybeUninit<u32> = MaybeUninit::uninit();

// SAFETY: as above.
#[unsafe(link_section = ".uninit.crash")]
static mut CRASH: MaybeUninit<CrashRecord> = MaybeUninit::uninit();

static STARTED: AtomicBool = AtomicBool::new(false);
static BARRED: AtomicBool = AtomicBool::new(false);
static AFTER_CRASH: AtomicBool = AtomicBool::new(false);

/// Whether the board crashed too often to be armed. The first call, from `main` before any task
/// runs, records this start; `by_watchdog` says whether the watchdog caused it.
pub fn barred(by_watchdog: bool) -> bool {
    if !STARTED.swap(true, Ordering::Relaxed) {
        // SAFETY: every bit pattern is valid for a `u32` and for a `Resets`, whose fields are
        // integers; no other task runs yet.
        let (resets, cause) = unsafe { (&mut *(&raw mut RESETS).cast::<Resets>(), &mut *(&raw mut CAUSE).cast::<u32>()) };
        let cause = match core::mem::take(cause) {
            RESTARTED => Cause::Restart,
            CRASHED => Cause::Crash,
            _ if by_watchdog => Cause::Crash,
            _ => Cause::Power,
        };
        BARRED.store(resets.start(cause), Ordering::Relaxed);
        AFTER_CRASH.store(cause == Cause::Crash, Ordering::Relaxed);
        crash_record().start(cause == Cause::Crash);
    }
    BARRED.load(Ordering::Relaxed)
}

/// The record of the last crash.
fn crash_record() -> &'static mut CrashRecord {
    // SAFETY: every bit pattern is valid for the record, whose fields are integers. It is written
    // before any task runs and by a crash, which never returns to a reader.
    unsafe { &mut *(&raw mut CRASH).cast::<CrashRecord>() }
}

/// Keeps a crash for the next start.
pub fn keep(crash: &Crash) {
    crash_record().keep(crash);
}

/// The last crash since power-on.
pub fn last_crash() -> Option<Crash> {
    crash_record().last()
}

/// Whether a crash caused this start; valid after the first call of [`barred`].
pub fn crashed() -> bool {
    AFTER_CRASH.load(Ordering::Relaxed)
}

/// Adds a millisecond to the time under power.
pub fn count_millisecond() {
    // SAFETY: called from the haptic loop alone, after `barred` has given the memory a valid
    // content.
    unsafe { (*(&raw mut RESETS).cast::<Resets>()).count() };
}

/// Resets the board as its watchdog would.
pub fn restart() -> ! {
    mark(CRASHED);
    cortex_m::peripheral::SCB::sys_reset()
}

/// Lets the next start know that the reset to come is meant.
#[cfg(not(feature = "mps2"))]
pub fn mark_restart() {
    mark(RESTARTED);
}

fn mark(cause: u32) {
    // SAFETY: interrupts are off, so nothing else runs.
    unsafe { (&raw mut CAUSE).cast::<u32>().write_volatile(cause) };
}
