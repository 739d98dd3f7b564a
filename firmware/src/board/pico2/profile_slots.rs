//! The last two sectors of the serial flash, for profiles. The boot ROM erases and writes them,
//! while the program that calls it runs from RAM.

use embassy_rp::flash::{Blocking, ERASE_SIZE, FLASH_BASE, Flash};
use embassy_rp::pac::WATCHDOG;
use embassy_rp::peripherals;
use palpate_controller::config::{FlashError, SLOT_BYTES, Slot};

/// Size of the flash of a Pico 2 [bytes].
const FLASH_SIZE: usize = 4 * 1024 * 1024;

/// Distance of a slot from the beginning of the flash [bytes].
fn offset(slot: Slot) -> u32 {
    let sectors = if slot == Slot::A { 2 } else { 1 };
    (FLASH_SIZE - sectors * ERASE_SIZE) as u32
}

/// Address of a slot.
pub fn address(slot: Slot) -> usize {
    FLASH_BASE as usize + offset(slot) as usize
}

fn flash() -> Flash<'static, peripherals::FLASH, Blocking, FLASH_SIZE> {
    // a reset of the core alone leaves the watchdog running
    WATCHDOG.ctrl().modify(|w| w.set_enable(false));
    // SAFETY: nothing else in the image uses this peripheral.
    Flash::new_blocking(unsafe { peripherals::FLASH::steal() })
}

/// Erases a slot.
pub fn erase(slot: Slot) -> Result<(), FlashError> {
    let first = offset(slot);
    flash().blocking_erase(first, first + ERASE_SIZE as u32).map_err(|_| FlashError)
}

/// Writes an erased slot.
pub fn write(slot: Slot, bytes: &[u8; SLOT_BYTES]) -> Result<(), FlashError> {
    flash().blocking_write(offset(slot), bytes).map_err(|_| FlashError)
}
