//! The interface of a board to the controller. `firmware/src/board/` implements it for real and
//! emulated boards, and the tests implement it for a mock board.

use palpate::Fault;

pub use crate::about::About;
use crate::config::Flash;
use crate::force_out::Outputs;
use crate::link::Log;
use crate::log::Event;
use crate::patch::Budget;
use crate::probe_in::Reading;

/// The watchdog of every board acts after this long without a completed tick [us]: less than the 5
/// ms within which the actuators must be off, and more than two late ticks in a row take, which
/// release the force themselves.
pub const WATCHDOG_US: u32 = 4_500;

/// Clock, pins, watchdog and link of a board. No function waits, except [`Board::next_period`] and
/// the read of a lock-step link.
#[expect(async_fn_in_trait, reason = "each image has one board and one executor; no bound on the future is needed")]
pub trait Board {
    /// The two slots that hold device profiles.
    type ProfileMemory: Flash;

    /// A free-running, wrapping clock [counts].
    fn clock_counts(&self) -> u32;

    /// Time since the last edge of the tick timer [counts].
    fn since_period_counts(&self) -> u32;

    /// Periods that the tick timer has begun, wrapping. Counted at a higher priority than the loop,
    /// so that a tick that is still busy is seen as late.
    fn periods_begun(&self) -> u32;

    /// Waits for the next period and returns its number.
    async fn next_period(&mut self) -> u32;

    /// Drops a period that began while a tick was late: the next tick starts on an edge.
    fn drop_period(&mut self);

    /// Puts codes and enable line on the pins; off takes effect first, on last.
    fn write_outputs(&mut self, outputs: Outputs);

    /// The outputs, read back from the pins.
    fn outputs(&self) -> Outputs;

    /// Releases the force.
    fn outputs_off(&mut self);

    /// Keeps the watchdog from turning the outputs off and resetting the board.
    fn feed_watchdog(&mut self);

    /// Counts a millisecond of time under power, for [`crate::resets`].
    fn count_millisecond(&mut self);

    /// The board's part of the self-test.
    fn healthy(&self) -> bool;

    /// Whether the actuators' supply is too low now.
    fn supply_low(&self) -> bool;

    /// The fault while the stop circuit is open, or after it was.
    fn emergency_stop(&mut self) -> Option<Fault>;

    /// Whether the operator's switch is released; `None` on a board without a pin for one.
    fn operator_absent(&self) -> Option<bool>;

    /// Reading of the board's own encoders, if it has any. The controller turns it into a tip.
    fn sense(&mut self) -> Option<Reading>;

    /// Cycles that a patch may take per tick.
    fn budget(&self) -> Budget;

    /// Image and clock.
    fn about(&self) -> About;

    /// Largest stack use so far [bytes].
    fn stack_used_bytes(&self) -> usize;

    /// The memory for device profiles.
    fn profile_memory(&mut self) -> &mut Self::ProfileMemory;

    /// Reads bytes from the host and returns their number. In lock-step it waits, and 0 means that
    /// the host has gone.
    fn link_read(&mut self, bytes: &mut [u8]) -> usize;

    /// Writes a frame to the host, or drops it whole.
    fn link_write(&mut self, frame: &[u8]);

    /// Bytes that [`Self::link_write`] would take now.
    fn link_room(&self) -> usize;

    /// Encodes an event for the log, without waiting. A board without a log drops it.
    fn log(&mut self, _: Event) {}

    /// Takes what waits of the log, as much as a message holds.
    fn take_log(&mut self) -> Option<Log> {
        None
    }
}
