//! The interface through which the controller uses a board. `firmware/src/board/` implements it for
//! real and emulated boards, and the tests implement it for a mock board.

use palpate::Fault;

pub use crate::about::About;
use crate::config::{self, Flash, Profile, StoreError};
use crate::crash::Crash;
use crate::force_out::Outputs;
use crate::link::Log;
use crate::log::Event;
use crate::patch::Budget;
use crate::probe_in::Reading;

/// Time without a completed tick after which the watchdog of every board acts [us]. It is shorter
/// than the 5 ms within which the actuators must be off, and longer than two consecutive late
/// ticks, which release the force without the watchdog.
pub const WATCHDOG_US: u32 = 4_500;

/// Clock, pins, watchdog and link of a board. No function blocks, except [`Board::next_period`] and
/// the read of a lock-step link.
#[expect(async_fn_in_trait, reason = "each image has one board and one executor; no bound on the future is needed")]
pub trait Board {
    /// The two slots that hold device profiles.
    type ProfileMemory: Flash;

    /// A free-running, wrapping clock [counts].
    fn clock_counts(&self) -> u32;

    /// Time since the last edge of the tick timer [counts].
    fn since_period_counts(&self) -> u32;

    /// Number of periods that the tick timer has begun; it wraps. It is counted at a higher
    /// priority than that of the loop, so that a tick that is still running is detected as late.
    fn periods_begun(&self) -> u32;

    /// Waits for the next period and returns its number.
    async fn next_period(&mut self) -> u32;

    /// Discards a period that began while a late tick was running, so that the next tick starts on
    /// an edge of the tick timer.
    fn drop_period(&mut self);

    /// Writes the codes and the enable line to the pins. The enable line is switched off before the
    /// codes change, and on after they have changed.
    fn write_outputs(&mut self, outputs: Outputs);

    /// Reads the outputs back from the pins.
    fn outputs(&self) -> Outputs;

    /// Releases the force: enable line off, no force on any axis.
    fn outputs_off(&mut self);

    /// Restarts the watchdog's time; otherwise it turns the outputs off and resets the board.
    fn feed_watchdog(&mut self);

    /// Adds a millisecond to the time under power, by which [`crate::resets`] dates crashes.
    fn count_millisecond(&mut self);

    /// The last crash since power-on.
    fn last_crash(&self) -> Option<Crash>;

    /// Whether the board's part of the self-test is passed: the outputs are off, and the break
    /// input is armed on boards that have one.
    fn healthy(&self) -> bool;

    /// Whether the actuators' supply voltage is too low at present.
    fn supply_low(&self) -> bool;

    /// [`Fault::EmergencyStop`] while the stop circuit is open. A board that latches a trip in
    /// hardware also reports, once, a trip that is already over.
    fn emergency_stop(&mut self) -> Option<Fault>;

    /// Whether the operator's switch is released; `None` on a board without a pin for one.
    fn operator_absent(&self) -> Option<bool>;

    /// Reading of the board's own encoders, if it has any. The controller converts it to a tip
    /// position.
    fn sense(&mut self) -> Option<Reading>;

    /// Cycles that a patch may take per tick.
    fn budget(&self) -> Budget;

    /// Image and clock of the board, for hosts.
    fn about(&self) -> About;

    /// Largest stack use so far [bytes].
    fn stack_used_bytes(&self) -> usize;

    /// The memory for device profiles.
    fn profile_memory(&mut self) -> &mut Self::ProfileMemory;

    /// Stores a profile that was checked, with the outputs off, and returns its generation. A board
    /// whose flash is too slow for its watchdog restarts instead of returning, and stores the
    /// profile then.
    ///
    /// # Errors
    /// As [`config::store`].
    fn store_profile(&mut self, profile: &Profile) -> Result<u32, StoreError> {
        config::store(self.profile_memory(), profile)
    }

    /// Generation of the profile for which the board has restarted; zero if it could not be stored
    /// and is used until power-off.
    fn restarted_for(&mut self) -> Option<u32> {
        None
    }

    /// Reads bytes from the host and returns their number. In lock-step it waits, and 0 means that
    /// the host has gone.
    fn link_read(&mut self, bytes: &mut [u8]) -> usize;

    /// Writes a frame to the host, or drops it whole.
    fn link_write(&mut self, frame: &[u8]);

    /// Number of bytes that [`Self::link_write`] would accept now.
    fn link_room(&self) -> usize;

    /// Encodes an event for the log without blocking. A board without a log drops it.
    fn log(&mut self, _: Event) {}

    /// Removes the oldest pending frames of the log, as many as fit into a message.
    fn take_log(&mut self) -> Option<Log> {
        None
    }
}
