//! The way out: whatever goes wrong, the outputs are at zero before anything is said about it.

use core::{fmt, panic::PanicInfo};

use palpate_controller::force_out::Outputs;

use crate::board;

/// Releases the force, then prints the reason and leaves the rest to the board: the watchdog's reset, or the end of an emulated run.
pub fn stop(reason: fmt::Arguments<'_>) -> ! {
    // no interrupt may put a force back after this
    cortex_m::interrupt::disable();
    board::outputs_off();
    board::print(reason);
    board::print(format_args!("{}", if board::outputs() == Outputs::OFF { "outputs off" } else { "OUTPUTS ON" }));
    board::after_crash()
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    stop(format_args!("{info}"))
}
