//! Parts shared by all real boards: none has a file system, an exit, or a memory for profiles yet.

use core::fmt;

use palpate_controller::config::{Flash, FlashError, SLOT_BYTES, Slot};
#[cfg(not(feature = "self-test"))]
use palpate_controller::serve::Pace;

use super::Duty;

/// Serves a host.
#[cfg(not(feature = "self-test"))]
pub fn duty() -> Duty {
    Duty::Serve(Pace::Timed)
}

/// Waits for the next interrupt.
pub fn idle(_: &Duty) {
    cortex_m::asm::wfi();
}

/// Words for the debugger's log; lost without one.
pub fn print(line: fmt::Arguments<'_>) {
    defmt::error!("{}", defmt::Display2Format(&line));
}

/// There is nowhere to return to: the outputs are off, and the watchdog restarts the board.
pub fn exit(_: bool) -> ! {
    after_crash()
}

/// Waits for the watchdog's reset.
pub fn after_crash() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

/// These boards store no profile yet and use the default one: erasing their flash takes longer than
/// the watchdog's time, and words left half written by a power cut may cause a bus fault when read,
/// which has not been tried on a board.
#[derive(Default)]
pub struct ProfileMemory;

impl Flash for ProfileMemory {
    fn read(&self, _: Slot, bytes: &mut [u8; SLOT_BYTES]) {
        *bytes = [0xFF; SLOT_BYTES];
    }

    fn erase(&mut self, _: Slot) -> Result<(), FlashError> {
        Err(FlashError)
    }

    fn write(&mut self, _: Slot, _: &[u8; SLOT_BYTES]) -> Result<(), FlashError> {
        Err(FlashError)
    }
}
