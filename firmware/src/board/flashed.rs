//! Parts that all boards share which are flashed: none has a file system, an end, or a memory for
//! profiles yet.

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

/// Until the next interrupt.
pub fn idle(_: &Duty) {
    cortex_m::asm::wfi();
}

/// Words for the debugger's log; lost without one.
pub fn print(line: fmt::Arguments<'_>) {
    defmt::error!("{}", defmt::Display2Format(&line));
}

/// There is nowhere to go to: the outputs are off, and the watchdog starts anew.
pub fn exit(_: bool) -> ! {
    after_crash()
}

/// Waits for the watchdog's reset.
pub fn after_crash() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

/// No profile is kept on these boards yet, the default one holds: erasing their flash takes longer
/// than the watchdog bears, and what a power cut has left half written may read as a bus fault,
/// which nobody has seen on a board.
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
