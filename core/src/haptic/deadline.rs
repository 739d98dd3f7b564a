//! The deadline rule: consequences of a tick that ends after its period.
//!
//! The caller counts the periods that passed without a new force and passes the count to each cycle
//! as [`super::cycle::Command::late_ticks`]. A single missed period is tolerated: the device has
//! held the old force for two periods, so this tick gives at most half of it. Two in a row, or five
//! among 1000 ticks, mean a loop slower than the one its gains were tuned for.
//!
//! * in: periods missed since the last cycle
//! * out: whether this tick may give at most half the last force
//! * cost: 20 instructions of a Cortex-M4F, estimated
//! * failures: [`Fault::DeadlineMissed`]

use crate::fault::Fault;

/// Number of missed periods in a row that is a fault.
/// Source: chosen; a single missed period is the least that can be tolerated.
pub const IN_A_ROW: u16 = 2;
/// Number of misses among [`WINDOW_TICKS`] that is a fault.
/// Source: derived; each miss takes half of a force away and the slew limit returns it within six
/// ticks, so that five cost up to 1.5 % of a second's force
/// (`the_fifth_late_tick_within_a_second_is_a_fault`).
pub const AMONG: usize = 5;
/// Ticks over which misses are counted.
/// Source: derived; a second at 1 kHz, as in the line above.
pub const WINDOW_TICKS: u16 = 1000;

/// Counts late ticks.
#[derive(Clone, Copy, Debug)]
pub struct Deadline {
    /// Cycles so far, wrapping.
    now: u32,
    /// Cycle numbers of the last tolerated misses, newest first; one miss more within the window is
    /// a fault.
    missed: [u32; AMONG - 1],
}

impl Default for Deadline {
    fn default() -> Self {
        // the last misses were long ago
        Self { now: 2 * u32::from(WINDOW_TICKS), missed: [0; AMONG - 1] }
    }
}

impl Deadline {
    /// Runs one cycle, given the periods that were missed before it. Returns true for a single
    /// miss, which is tolerated.
    ///
    /// # Errors
    /// Fails with [`Fault::DeadlineMissed`] if [`IN_A_ROW`] periods in a row were missed, or if
    /// this is miss number [`AMONG`] within [`WINDOW_TICKS`].
    pub fn judge(&mut self, late_ticks: u16) -> Result<bool, Fault> {
        self.now = self.now.wrapping_add(1);
        if late_ticks == 0 {
            return Ok(false);
        }
        let [newest, .., oldest] = self.missed.map(|tick| self.now.wrapping_sub(tick));
        let often = oldest < u32::from(WINDOW_TICKS);
        if late_ticks >= IN_A_ROW || newest < u32::from(IN_A_ROW) || often {
            return Err(Fault::DeadlineMissed);
        }
        self.missed.rotate_right(1);
        if let Some(newest) = self.missed.first_mut() {
            *newest = self.now;
        }
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tick of the fault if these ticks are late by one period.
    fn fault_at(late: impl Fn(u32) -> bool) -> Option<u32> {
        let mut deadline = Deadline::default();
        (0..10_000).find(|&n| deadline.judge(u16::from(late(n))).is_err())
    }

    #[test]
    fn one_miss_halves_and_two_in_a_row_or_five_of_a_thousand_are_a_fault() {
        let mut deadline = Deadline::default();
        assert_eq!([0, 1, 0, 1, 0].map(|late| deadline.judge(late)), [false, true, false, true, false].map(Ok));
        assert_eq!(Deadline::default().judge(2), Err(Fault::DeadlineMissed), "two periods at once are two in a row");
        assert_eq!(fault_at(|n| n == 7 || n == 8), Some(8));
        assert_eq!(fault_at(|n| n % 249 == 0), Some(996), "the fifth within 1000 ticks");
        assert_eq!(fault_at(|n| n % 250 == 0), None, "the fifth is the first of the next thousand");
        assert_eq!(fault_at(|n| n < 8 && n % 2 == 0), None, "four are forgiven");
    }
}
