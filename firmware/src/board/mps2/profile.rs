//! The memory for profiles: these images have no flash, so it is RAM that start-up does not clear.

use core::mem::MaybeUninit;

use palpate_controller::config::{self, Flash, FlashError, Profile, SLOT_BYTES, Slot};

// SAFETY: nothing else is put into this section; the name is unique.
#[unsafe(link_section = ".uninit.slots")]
static mut SLOTS: MaybeUninit<[[u8; SLOT_BYTES]; 2]> = MaybeUninit::uninit();

/// Two slots of RAM in place of flash.
#[derive(Default)]
pub struct ProfileMemory;

impl ProfileMemory {
    /// Calls `act` with the index and the address of each byte of a slot. All accesses share this
    /// loop, since copying a whole slot takes a kilobyte of code, and so would every further loop.
    #[inline(never)]
    fn each(slot: Slot, act: &mut dyn FnMut(usize, *mut u8)) {
        let first = if slot == Slot::B { SLOT_BYTES } else { 0 };
        for at in 0..SLOT_BYTES {
            // SAFETY: the address is within the two slots.
            act(at, unsafe { (&raw mut SLOTS).cast::<u8>().add(first + at) });
        }
    }
}

impl Flash for ProfileMemory {
    fn read(&self, slot: Slot, bytes: &mut [u8; SLOT_BYTES]) {
        // SAFETY: any content of the RAM is valid as bytes; one task at a time uses the slots:
        // `main`, then the haptic loop.
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

/// The profile that this memory keeps.
pub fn kept_profile(memory: &mut ProfileMemory) -> Option<Profile> {
    config::load(memory).map(|kept| kept.0)
}
