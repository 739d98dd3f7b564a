//! The last two sectors of the chip's flash, for profiles: 128 KB each, 2 KB on the G474.

use embassy_stm32::flash::{Blocking, FLASH_BASE, FLASH_SIZE, Flash, MAX_ERASE_SIZE};
use embassy_stm32::peripherals;
use palpate_controller::config::{FlashError, SLOT_BYTES, Slot};

use super::{Stm32Board, This};

/// Distance of a slot from the beginning of the flash [bytes].
fn offset(slot: Slot) -> u32 {
    let sectors = if slot == Slot::A { 2 } else { 1 };
    (FLASH_SIZE - sectors * MAX_ERASE_SIZE) as u32
}

/// Address of a slot.
pub fn address(slot: Slot) -> usize {
    FLASH_BASE + offset(slot) as usize
}

fn flash() -> Flash<'static, Blocking> {
    // SAFETY: nothing else in the image uses this peripheral.
    Flash::new_blocking(unsafe { peripherals::FLASH::steal() })
}

/// Erases a slot.
pub fn erase(slot: Slot) -> Result<(), FlashError> {
    let first = offset(slot);
    let erased = flash().blocking_erase(first, first + MAX_ERASE_SIZE as u32);
    This::discard_caches();
    erased.map_err(|_| FlashError)
}

/// Writes an erased slot.
pub fn write(slot: Slot, bytes: &[u8; SLOT_BYTES]) -> Result<(), FlashError> {
    let written = flash().blocking_write(offset(slot), bytes);
    This::discard_caches();
    written.map_err(|_| FlashError)
}
