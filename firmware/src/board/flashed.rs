//! Parts shared by all real boards: none of them has a file system, a way to exit or, as yet, a
//! memory for profiles.

use core::fmt;

use rtt_target::{ChannelMode, UpChannel, rtt_init};

use palpate_controller::config::{Flash, FlashError, SLOT_BYTES, Slot};
#[cfg(not(feature = "self-test"))]
use palpate_controller::serve::Pace;

use super::Duty;

/// The task of every image for a real board, except the self-test: to serve a host.
#[cfg(not(feature = "self-test"))]
pub fn duty() -> Duty {
    Duty::Serve(Pace::Timed)
}

/// Waits for the next interrupt.
pub fn idle(_: &Duty) {
    cortex_m::asm::wfi();
}

/// Opens the channel from which a debug probe reads the log. Writes do not wait for a probe:
/// without one the channel fills up, and later bytes are dropped.
pub fn debug_start(_: &Duty) {
    rtt_init! {
        up: { 0: { size: 1024, mode: ChannelMode::NoBlockTrim, name: "defmt" } }
    };
}

/// Writes bytes of a frame; called with interrupts off.
pub fn debug_write(bytes: &[u8]) {
    // SAFETY: the channel that `debug_start` has opened; before that there is none. Nothing else
    // writes to it, and interrupts are off.
    if let Some(mut channel) = unsafe { UpChannel::conjure(0) } {
        channel.write(bytes);
    }
}

/// Prints a line to the debugger's log; without a debugger the line is lost.
pub fn print(line: fmt::Arguments<'_>) {
    defmt::error!("{}", defmt::Display2Format(&line));
}

/// Waits for the watchdog's reset, since there is nothing to return to; the outputs are off.
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
