//! What happens when a tick ends after its period.

/// Late ticks in a row that are a fault: the controller really runs below 500 Hz, where the margin that the gains were tuned for is gone.
/// A single one costs the hand one doubled hold of the old force.
pub const LATE_IN_A_ROW: u32 = 2;
/// Late ticks within [`WINDOW_TICKS`] that are a fault.
pub const LATE_IN_WINDOW: usize = 5;
/// Ticks over which scattered late ones are counted.
pub const WINDOW_TICKS: u32 = 1_000;

/// Judges every tick by the periods that began before its force was ready.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Deadline {
    overruns: u32,
    in_a_row: u32,
    ticks: u32,
    /// When the latest were late, oldest first [tick].
    late_at: [Option<u32>; LATE_IN_WINDOW - 1],
}

impl Deadline {
    /// Records one finished tick; `periods_late` is 0 when the force was ready within its own period. True if the force must go.
    pub fn close(&mut self, periods_late: u32) -> bool {
        self.ticks = self.ticks.wrapping_add(1);
        if periods_late == 0 {
            self.in_a_row = 0;
            return false;
        }
        self.overruns = self.overruns.saturating_add(1);
        self.in_a_row = self.in_a_row.saturating_add(1);
        let [oldest, ..] = self.late_at;
        self.late_at.rotate_left(1);
        if let Some(newest) = self.late_at.last_mut() {
            *newest = Some(self.ticks);
        }
        let crowded = oldest.is_some_and(|at| self.ticks.wrapping_sub(at) < WINDOW_TICKS);
        self.in_a_row >= LATE_IN_A_ROW || crowded
    }

    /// Ticks that ended late since the start.
    #[must_use]
    pub const fn overruns(&self) -> u32 {
        self.overruns
    }
}

#[cfg(test)]
mod tests {
    use super::{Deadline, LATE_IN_WINDOW, WINDOW_TICKS};

    /// Ticks until the force goes, when every `every`-th is late.
    fn lasts(every: u32) -> Option<u32> {
        let mut deadline = Deadline::default();
        (0..20_000).find(|tick| deadline.close(u32::from(tick % every == 0)))
    }

    #[test]
    fn two_in_a_row_are_too_many() {
        assert_eq!(lasts(1), Some(1));
    }

    #[test]
    fn scattered_ones_are_forgiven_until_five_come_in_a_second() {
        assert_eq!(lasts(2), Some(8), "the fifth late tick");
        assert_eq!(lasts(WINDOW_TICKS / (LATE_IN_WINDOW as u32 - 1) - 1), Some(4 * 249));
        assert_eq!(lasts(WINDOW_TICKS / (LATE_IN_WINDOW as u32 - 1)), None);
    }

    #[test]
    fn all_are_counted() {
        let mut deadline = Deadline::default();
        (0..3_000_u32).for_each(|tick| {
            deadline.close(u32::from(tick % 3 == 0) * (1 + tick % 20));
        });
        assert_eq!(deadline.overruns(), 1_000);
    }
}
