//! The board port. A board file provides:
//!
//! * `start_executors() -> (haptic, background)`, the first preempting the second;
//! * `start_tick_timer()`, which calls [`crate::period::on_period`] from an interrupt above both,
//!   every millisecond, and arms the watchdog;
//! * `feed_watchdog()`, without which the board calls [`stop`] after some periods, at the highest
//!   priority;
//! * `NAME`, board and version of the image, and `clock_hz()`, counts of the clock per second;
//! * `clock_counts() -> u32`, free running and wrapping, and `counts_to_ns`;
//!   `since_period_counts()`, the same since the tick timer's last edge;
//! * `write_outputs(outputs)`, `outputs()` to read them back from the pins, and `outputs_off()`,
//!   which may be called in any context, even in a fault handler;
//! * `emergency_stop()`, the fault while the stop circuit is open or after it was open;
//!   `operator_absent()`, whether the operator's switch is released, if the board has a pin for
//!   one; `budget()`, the cycles that a patch may take per tick;
//! * `healthy()`, the board's part of the self-test; `supply_low()`, whether the actuators' supply
//!   is too low now;
//! * `stack_used_bytes()`, the largest use of the stack so far, of `STACK_BYTES`;
//! * `barred()`, whether the watchdog has reset the board too often
//!   ([`palpate_controller::resets`]), `count_millisecond()` for its clock, and `after_crash() ->
//!   !`, called when the outputs are off and the reason is printed;
//! * `ProfileMemory`, the two slots of [`palpate_controller::config`];
//! * `duty()`, the task of the image, and `exit(success) -> !`;
//! * `link_read(bytes)` and `link_write(bytes)`, the link to the host: neither waits, except for
//!   the read of a lock-step link;
//! * `sense()`, the reading of the board's own sensors, if it has any;
//! * `idle(duty)`, which waits for the next interrupt;
//! * for the self-test `CLOCK_KIND`, the clock's unit in words, `chip_id()`, the chip's own
//!   identification, `led(on)`, and `after_report(passed)`, which ends an emulated run;
//! * `print(line)`, plain text at the end of a run; `debug_start(duty)` and `debug_write(bytes)`,
//!   where the log goes beside the link, and `link_room()`, the bytes that the link would take now;
//! * the handlers of `HardFault` and of unclaimed interrupts, both ending in [`stop`].
//!
//! Nothing outside this folder is `unsafe`.

use core::{fmt, panic::PanicInfo};
use palpate_controller::board::About;
use palpate_controller::force_out::Outputs;

use palpate_controller::script::Script;
use palpate_controller::serve::Pace;

include!(concat!(env!("OUT_DIR"), "/built_day.rs"));

/// Task of an image.
#[derive(Clone, Copy)]
pub enum Duty {
    /// A scripted hand presses, in real time.
    #[cfg_attr(not(feature = "mps2"), expect(dead_code, reason = "a board with sensors needs no scripted hand"))]
    Script(Script),
    /// A host is on the link.
    #[cfg_attr(all(feature = "self-test", not(feature = "mps2")), expect(dead_code, reason = "a self-test serves no host"))]
    Serve(Pace),
    /// The board is tested, without motors and without a host.
    #[cfg(feature = "self-test")]
    SelfTest,
}

#[expect(unsafe_code, reason = "a section of its own")]
mod fit_record;
#[expect(unsafe_code, reason = "a logger is unsafe to write, and its state is shared with fault handlers")]
pub mod log;
#[expect(unsafe_code, reason = "memory that outlives a reset is no plain static")]
mod resets;
mod this_board;
pub use this_board::ThisBoard;
#[expect(unsafe_code, reason = "the stack's bounds are the linker's, and a hard fault needs a fresh one")]
mod stack;
pub use resets::count_millisecond;
pub use stack::{STACK_BYTES, stack_used_bytes};

#[cfg(not(feature = "mps2"))]
#[expect(unsafe_code, reason = "memory is filled by the linker's symbols")]
mod fast_memory;

#[cfg(not(feature = "mps2"))]
#[expect(unsafe_code, reason = "the debug channel is memory that a probe reads")]
mod flashed;

#[cfg(feature = "pico2")]
#[expect(unsafe_code, reason = "interrupt entry and registers shared with fault handlers are the board's to touch")]
mod pico2;
#[cfg(feature = "pico2")]
use pico2 as family;

#[cfg(feature = "stm32")]
#[expect(unsafe_code, reason = "interrupt entry and registers shared with fault handlers are the board's to touch")]
mod stm32;
#[cfg(feature = "stm32")]
use stm32 as family;

#[cfg(feature = "mps2")]
#[expect(unsafe_code, reason = "registers, vector table and interrupt entry are the board's to touch")]
mod mps2;
#[cfg(feature = "mps2")]
use mps2 as family;

#[cfg(not(any(feature = "mps2", feature = "pico2", feature = "stm32")))]
compile_error!("name a board: --features mps2, nucleo-h743zi, nucleo-f446re, nucleo-g474re or pico2");

pub use family::{
    NAME, ProfileMemory, after_crash, barred, budget, clock_counts, clock_hz, counts_to_ns, emergency_stop, exit, feed_watchdog,
    healthy, idle, link_read, link_room, link_write, operator_absent, outputs, outputs_off, print, sense, since_period_counts,
    start_executors, start_tick_timer, supply_low, write_outputs,
};

#[cfg(feature = "self-test")]
pub use family::{CLOCK_KIND, after_report, chip_id, led};

/// The task of the image.
pub fn duty() -> Duty {
    #[cfg(feature = "self-test")]
    return Duty::SelfTest;
    #[cfg(not(feature = "self-test"))]
    family::duty()
}

/// Image and clock, for hosts. The build script knows the day.
pub fn about() -> About {
    About { name: NAME, built_day: BUILT_DAY, clock_hz: clock_hz(), image: log::image() }
}

/// Releases the force, then prints the reason and leaves the rest to the board: the watchdog's
/// reset, or the end of an emulated run.
pub fn stop(reason: fmt::Arguments<'_>) -> ! {
    // no interrupt may restore a force after this
    cortex_m::interrupt::disable();
    outputs_off();
    print(reason);
    print(format_args!("{}", if outputs() == Outputs::OFF { "outputs off" } else { "OUTPUTS ON" }));
    after_crash()
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    stop(format_args!("{info}"))
}
