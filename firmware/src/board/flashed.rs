//! Parts shared by all real boards: none of them has a file system or a way to exit.

use core::fmt;

use rtt_target::{ChannelMode, UpChannel, rtt_init};

#[cfg(not(feature = "self-test"))]
use palpate_controller::serve::Pace;

use super::{Duty, profile_flash, resets};

/// The task of every image for a real board, except the self-test: to serve a host.
#[cfg(not(feature = "self-test"))]
pub fn duty() -> Duty {
    Duty::Serve(Pace::Timed)
}

/// Waits for the next interrupt.
pub fn idle(_: &Duty) {
    cortex_m::asm::wfi();
}

/// Opens the channel from which a debug probe reads the log.
pub fn debug_start(_: &Duty) {
    rtt_init! {
        up: { 0: { size: 1024, mode: ChannelMode::NoBlockTrim, name: "defmt" } }
    };
}

/// Writes bytes of a frame; called with interrupts off. Writes never wait: bytes that the channel
/// has no room for are dropped. A probe's program may have asked for waiting, which would let the
/// watchdog act whenever it reads slowly.
pub fn debug_write(bytes: &[u8]) {
    // SAFETY: the channel that `debug_start` has opened; before that there is none. Nothing else
    // writes to it, and interrupts are off.
    if let Some(mut channel) = unsafe { UpChannel::conjure(0) } {
        channel.set_mode(ChannelMode::NoBlockTrim);
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

/// Waits for the watchdog's reset, or resets the board if it crashed in reading a profile, before
/// the watchdog runs.
pub fn after_crash() -> ! {
    if profile_flash::is_reading() {
        resets::restart();
    }
    loop {
        cortex_m::asm::nop();
    }
}
