//! What outlives a reset: RAM that start-up does not clear stands for a backup register and for flash, which these images lack.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

use palpate_firmware::config::{Flash, FlashError, SLOT_BYTES, Slot};
use palpate_firmware::resets::{Cause, Resets};

/// Says that the reset was ours, not the power's.
const CRASHED: u32 = 0xC4A5_4ED0;

// SAFETY: nothing else is put into this section; the names are no others.
#[unsafe(link_section = ".uninit.resets")]
static mut RESETS: MaybeUninit<Resets> = MaybeUninit::uninit();
// SAFETY: as above.
#[unsafe(link_section = ".uninit.cause")]
static mut CAUSE: MaybeUninit<u32> = MaybeUninit::uninit();
// SAFETY: as above.
#[unsafe(link_section = ".uninit.slots")]
static mut SLOTS: MaybeUninit<[[u8; SLOT_BYTES]; 2]> = MaybeUninit::uninit();

static STARTED: AtomicBool = AtomicBool::new(false);
static BARRED: AtomicBool = AtomicBool::new(false);

/// Whether crashes came too often. The first call counts this start; it comes from `main`, before anything else runs.
pub fn barred() -> bool {
    if !STARTED.swap(true, Ordering::Relaxed) {
        // SAFETY: every bit pattern is a `u32`, and a `Resets` of nothing but integers; nothing else runs yet.
        let (resets, cause) = unsafe { (&mut *(&raw mut RESETS).cast::<Resets>(), &mut *(&raw mut CAUSE).cast::<u32>()) };
        let cause = if core::mem::take(cause) == CRASHED { Cause::Crash } else { Cause::Power };
        BARRED.store(resets.start(cause), Ordering::Relaxed);
    }
    BARRED.load(Ordering::Relaxed)
}

/// A tick has passed.
pub fn count_millisecond() {
    // SAFETY: from the haptic loop alone, after `barred` has made it a `Resets`.
    unsafe { (*(&raw mut RESETS).cast::<Resets>()).count() };
}

/// Resets the board as its watchdog would.
#[cfg(feature = "planted-crash")]
pub fn restart() -> ! {
    // SAFETY: interrupts are off: nobody else is here.
    unsafe { (&raw mut CAUSE).cast::<u32>().write_volatile(CRASHED) };
    cortex_m::peripheral::SCB::sys_reset()
}

/// Two slots of RAM in place of flash.
pub struct ProfileMemory;

impl ProfileMemory {
    fn at(slot: Slot) -> *mut [u8; SLOT_BYTES] {
        // SAFETY: 0 and 1 are within the two slots.
        unsafe { (&raw mut SLOTS).cast::<[u8; SLOT_BYTES]>().add(usize::from(slot == Slot::B)) }
    }
}

impl Flash for ProfileMemory {
    fn read(&self, slot: Slot, bytes: &mut [u8; SLOT_BYTES]) {
        // SAFETY: whatever the RAM holds is bytes; one task at a time has the slots: `main`, then the haptic loop.
        *bytes = unsafe { Self::at(slot).read_volatile() };
    }

    fn erase(&mut self, slot: Slot) -> Result<(), FlashError> {
        // SAFETY: as in `read`.
        unsafe { Self::at(slot).write_volatile([0xFF; SLOT_BYTES]) };
        Ok(())
    }

    fn write(&mut self, slot: Slot, at: usize, bytes: &[u8]) -> Result<(), FlashError> {
        let mut kept = [0; SLOT_BYTES];
        self.read(slot, &mut kept);
        kept.get_mut(at..at.saturating_add(bytes.len())).ok_or(FlashError)?.copy_from_slice(bytes);
        // SAFETY: as in `read`.
        unsafe { Self::at(slot).write_volatile(kept) };
        Ok(())
    }
}
