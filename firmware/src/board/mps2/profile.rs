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
    fn at(slot: Slot) -> *mut [u8; SLOT_BYTES] {
        // SAFETY: 0 and 1 are within the two slots.
        unsafe { (&raw mut SLOTS).cast::<[u8; SLOT_BYTES]>().add(usize::from(slot == Slot::B)) }
    }
}

impl Flash for ProfileMemory {
    fn read(&self, slot: Slot, bytes: &mut [u8; SLOT_BYTES]) {
        // SAFETY: whatever the RAM holds is bytes; one task at a time has the slots: `main`, then
        // the haptic loop.
        *bytes = unsafe { Self::at(slot).read_volatile() };
    }

    fn erase(&mut self, slot: Slot) -> Result<(), FlashError> {
        // SAFETY: as in `read`.
        unsafe { Self::at(slot).write_volatile([0xFF; SLOT_BYTES]) };
        Ok(())
    }

    fn write(&mut self, slot: Slot, bytes: &[u8; SLOT_BYTES]) -> Result<(), FlashError> {
        // SAFETY: as in `read`.
        unsafe { Self::at(slot).write_volatile(*bytes) };
        Ok(())
    }
}
