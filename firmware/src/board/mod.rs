//! The board port. A board file provides:
//!
//! * `start_executors() -> (haptic, background)`, the first of which preempts the second;
//! * `start_tick_timer()`, which starts the watchdog and the timer that calls
//!   [`crate::period::on_period`] every millisecond from an interrupt above both;
//! * `feed_watchdog()`, without which the watchdog turns the outputs off after some periods and
//!   resets the board or, in the emulator, calls [`stop`];
//! * `NAME`, board and version of the image, and `clock_hz()`, the frequency of the clock;
//! * `clock_counts() -> u32`, free running and wrapping, and `counts_to_ns`;
//!   `since_period_counts()`, the counts since the tick timer's last edge;
//! * `write_outputs(outputs)`, `outputs()` to read them back from the pins, and `outputs_off()`,
//!   which may be called in any context, even in a fault handler;
//! * `emergency_stop()`, the fault of an open stop circuit; `operator_absent()`, whether the
//!   operator's switch is released, if the board has a pin for one; `budget()`, the cycles that a
//!   patch may take per tick;
//! * `healthy()`, the board's part of the self-test; `supply_low()`, whether the actuators' supply
//!   is too low now;
//! * `stack_used_bytes()`, the largest use of the stack so far, of `STACK_BYTES`;
//! * `barred()`, whether arming is barred after too many crashes ([`palpate_controller::resets`]),
//!   `count_millisecond()`, which adds to the time under power, and `after_crash() -> !`, called
//!   after the outputs were turned off and the reason was printed;
//! * `ProfileMemory`, the two slots of [`palpate_controller::config`]; a board with flash provides
//!   `profile_slots` instead, with the address of a slot, and functions that erase and write one;
//! * `duty()`, the task of the image, and `exit(success) -> !`;
//! * `link_read(bytes)` and `link_write(bytes)`, the link to the host: neither blocks, except the
//!   read of a lock-step link;
//! * `sense()`, the reading of the board's own sensors, if it has any;
//! * `idle(duty)`, which waits for the next interrupt;
//! * for the self-test `CLOCK_KIND`, the clock's unit in words, `chip()`, the chip's own
//!   identification with its brown-out level as it is and as it should be, `led(on)`, and
//!   `after_report(passed)`, which ends an emulated run;
//! * `print(line)`, plain text at the end of a run; `debug_start(duty)` and `debug_write(bytes)`,
//!   the debug channel, which carries the log in addition to the link, and `link_room()`, the
//!   number of bytes that the link would accept now;
//! * the handlers of `HardFault` and of unclaimed interrupts, both ending in [`stop`].
//!
//! Nothing outside this folder is `unsafe`.

use core::{fmt, panic::PanicInfo};
use palpate_controller::board::About;
use palpate_controller::crash::Crash;
use palpate_controller::force_out::Outputs;

use palpate_controller::script::Script;
use palpate_controller::serve::Pace;

include!(concat!(env!("OUT_DIR"), "/built_day.rs"));

/// Reciprocal of the time after which a pin is read back: 2 us, of which a Cortex-M7 may wait half.
/// A pin that drives 10 nF through 100 ohm has reached half of its swing by then.
#[cfg(not(feature = "mps2"))]
const SETTLES_HZ: u32 = 500_000;

/// Task that an image performs.
#[derive(Clone, Copy)]
pub enum Duty {
    /// Runs the controller in real time with a scripted hand.
    #[cfg_attr(not(feature = "mps2"), expect(dead_code, reason = "a board with sensors needs no scripted hand"))]
    Script(Script),
    /// Serves a host over the link.
    #[cfg_attr(all(feature = "self-test", not(feature = "mps2")), expect(dead_code, reason = "a self-test serves no host"))]
    Serve(Pace),
    /// Tests the board without motors and without a host.
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
#[expect(unsafe_code, reason = "one instruction, and a name that the linker looks for")]
mod square_root;
#[expect(unsafe_code, reason = "the stack's bounds are the linker's, and a hard fault needs a fresh one")]
mod stack;
pub use resets::{count_millisecond, last_crash};
pub use stack::{STACK_BYTES, stack_used_bytes};

#[cfg(not(feature = "dma-link"))]
mod by_interrupt;
mod queues;

#[cfg(not(feature = "mps2"))]
#[expect(unsafe_code, reason = "memory is filled by the linker's symbols")]
mod fast_memory;

#[cfg(not(feature = "mps2"))]
#[expect(unsafe_code, reason = "the debug channel is memory that a probe reads")]
mod flashed;

#[cfg(not(feature = "mps2"))]
#[expect(unsafe_code, reason = "flash is read by address, and what waits for it outlives a reset")]
mod profile_flash;
#[cfg(not(feature = "mps2"))]
pub use profile_flash::{ProfileMemory, kept_profile, restarted_for, store_by_restart};

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

#[cfg(feature = "mps2")]
pub use family::{ProfileMemory, kept_profile};

pub use family::{
    NAME, after_crash, barred, budget, clock_counts, clock_hz, counts_to_ns, emergency_stop, exit, feed_watchdog, healthy, idle,
    link_read, link_room, link_write, operator_absent, outputs, outputs_off, print, sense, since_period_counts, start_executors,
    start_tick_timer, supply_low, write_outputs,
};

#[cfg(feature = "self-test")]
pub use family::{CLOCK_KIND, after_report, chip, led};

/// The task of the image.
pub fn duty() -> Duty {
    #[cfg(feature = "self-test")]
    return Duty::SelfTest;
    #[cfg(not(feature = "self-test"))]
    family::duty()
}

/// Image and clock, for hosts; the build script provides the day.
pub fn about() -> About {
    About { name: NAME, built_day: BUILT_DAY, clock_hz: clock_hz(), image: log::image() }
}

/// Releases the force, then keeps and prints the reason and leaves the rest to the board: the
/// watchdog's reset, or the end of an emulated run.
pub fn stop(crash: &Crash, reason: fmt::Arguments<'_>) -> ! {
    // no interrupt may restore a force after this
    cortex_m::interrupt::disable();
    outputs_off();
    resets::keep(crash);
    print(reason);
    print(format_args!("{}", Plain(if outputs() == Outputs::OFF { "outputs off" } else { "OUTPUTS ON" })));
    after_crash()
}

/// Text to print as it is: the padding that `str` itself offers takes 2 KB of flash.
pub struct Plain<'a>(pub &'a str);

impl fmt::Display for Plain<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    outputs_off(); // first of all
    // without the message: what formats it and its values takes 3 KB of flash
    let (name, line) = info.location().map_or(("", 0), |place| (place.file(), place.line()));
    stop(&Crash::panic(name, line), format_args!("panic in line {line} of {}", Plain(name)))
}
