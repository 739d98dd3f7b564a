//! RAM that start-up does not clear stands for the flash that these images lack.

use core::mem::MaybeUninit;

use palpate_controller::config::{Flash, FlashError, SLOT_BYTES, Slot};

// SAFETY: nothing else is put into this section; the name is no other.
#[unsafe(link_section = ".uninit.slots")]
static mut SLOTS: MaybeUninit<[[u8; SLOT_BYTES]; 2]> = MaybeUninit::uninit();

/// Two slots of RAM in place of flash.
#[derive(Default)]
pub struct ProfileMemory;

impl ProfileMemory {
    /// Hands over the bytes of a slot one by one, from one loop for all: a whole slot in one access
    /// is a kilobyte of code, and so is every loop of its own.
    #[inline(never)]
    fn each(slot: Slot, act: &mut dyn FnMut(usize, *mut u8)) {
        let first = if slot == Slot::B { SLOT_BYTES } else { 0 };
        for at in 0..SLOT_BYTES {
            // SAFETY: within the two slots.
            act(at, unsafe { (&raw mut SLOTS).cast::<u8>().add(first + at) });
        }
    }
}

impl Flash for ProfileMemory {
    fn read(&self, slot: Slot, bytes: &mut [u8; SLOT_BYTES]) {
        // SAFETY: whatever the RAM holds is bytes; one task at a time has the slots: `main`, then
        // the haptic loop.
        Self::each(slot, &mut |at, kept| bytes[at] = unsafe { kept.read_volatile() });
    }

    fn erase(&mut self, slot: Slot) -> Result<(), FlashError> {
        // SAFETY: as in `read`.
        Self::each(slot, &mut |_, kept| unsafe { kept.write_volatile(0xFF) });
        Ok(())
    }

    fn write(&mut self, slot: Slot, bytes: &[u8; SLOT_BYTES]) -> Result<(), FlashError> {
        // SAFETY: as in `read`.
        Self::each(slot, &mut |at, kept| unsafe { kept.write_volatile(bytes[at]) });
        Ok(())
    }
}
