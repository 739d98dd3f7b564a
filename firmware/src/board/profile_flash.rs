//! The memory for profiles of real boards: the last two sectors of their flash.
//!
//! A sector takes up to two seconds to erase, which the watchdog does not bear. A new profile is
//! therefore set aside, the watchdog resets the board, and the start that follows stores it before
//! the watchdog runs.
//!
//! A word that was half written when the power failed may be unreadable: chips that correct errors
//! in flash answer with a fault. The slot in which that happens is erased by the next start.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};

use palpate_controller::aside::Aside;
use palpate_controller::config::{self, Flash, FlashError, Profile, SLOT_BYTES, Slot, StoreError};

use super::family::profile_slots;
use super::{outputs_off, resets};

// SAFETY: nothing else is put into this section; the names are unique.
#[unsafe(link_section = ".uninit.aside")]
static mut ASIDE: MaybeUninit<Aside> = MaybeUninit::uninit();
// SAFETY: as above.
#[unsafe(link_section = ".uninit.reading")]
static mut READING: MaybeUninit<u32> = MaybeUninit::uninit();

/// Marks that slot A is being read; slot B is the next number.
const READS_A: u32 = 0x51A7_0F0A;
/// Nothing was stored at this start.
const NOTHING: u32 = u32::MAX;
/// Generation that was stored at this start; zero if that failed.
static STORED: AtomicU32 = AtomicU32::new(NOTHING);

fn aside() -> &'static mut Aside {
    // SAFETY: every bit pattern is valid for its bytes. `main` uses it before any task runs, then
    // the haptic loop alone.
    unsafe { &mut *(&raw mut ASIDE).cast::<Aside>() }
}

fn reading() -> *mut u32 {
    (&raw mut READING).cast()
}

/// Two sectors of flash, of which the first bytes are used.
#[derive(Default)]
pub struct ProfileMemory;

impl Flash for ProfileMemory {
    fn read(&self, slot: Slot, bytes: &mut [u8; SLOT_BYTES]) {
        let first = profile_slots::address(slot) as *const u8;
        // SAFETY: a static of this file, which `main` alone uses.
        unsafe { reading().write_volatile(READS_A + slot as u32) };
        for (at, byte) in bytes.iter_mut().enumerate() {
            // SAFETY: the slot is flash that nothing writes now.
            *byte = unsafe { first.add(at).read_volatile() };
        }
        // SAFETY: as above.
        unsafe { reading().write_volatile(0) };
    }

    fn erase(&mut self, slot: Slot) -> Result<(), FlashError> {
        profile_slots::erase(slot)
    }

    fn write(&mut self, slot: Slot, bytes: &[u8; SLOT_BYTES]) -> Result<(), FlashError> {
        profile_slots::write(slot, bytes)
    }
}

/// Whether a slot is being read, which a crash interrupted.
pub fn is_reading() -> bool {
    // SAFETY: as in `read`.
    let mark = unsafe { reading().read_volatile() };
    mark == READS_A || mark == READS_A + 1
}

/// The profile to use, read before the watchdog runs. A slot that could not be read is erased, and
/// a profile that was set aside before the restart is stored, and used even if that fails.
pub fn kept_profile(memory: &mut ProfileMemory) -> Option<Profile> {
    // SAFETY: as in `read`; after power-on the content is random.
    let mark = unsafe { core::mem::replace(&mut *reading(), 0) };
    for slot in [Slot::A, Slot::B] {
        if mark == READS_A + slot as u32 {
            // where that fails, the slot stays unreadable and is tried again
            let _erased = memory.erase(slot);
        }
    }
    let Some(profile) = aside().take() else { return config::load(memory).map(|kept| kept.0) };
    STORED.store(config::store(memory, &profile).unwrap_or(0), Ordering::Relaxed);
    Some(profile)
}

/// Generation of the profile that this start stored, told once.
pub fn restarted_for() -> Option<u32> {
    let stored = STORED.load(Ordering::Relaxed);
    STORED.store(NOTHING, Ordering::Relaxed);
    (stored != NOTHING).then_some(stored)
}

/// Sets a profile aside and lets the watchdog reset the board, which stores it.
pub fn store_by_restart(profile: &Profile) -> Result<u32, StoreError> {
    if !aside().keep(profile) {
        return Err(StoreError::Flash);
    }
    cortex_m::interrupt::disable();
    outputs_off();
    resets::mark_restart();
    loop {
        cortex_m::asm::nop();
    }
}
