//! What happens when a tick ends after its period.

/// Late ticks in a row after which the force is released for good.
///
/// One late tick costs the hand one doubled hold of the old force, far under a millisecond-scale reflex; three in a row mean the
/// controller really runs below 333 Hz, where the stability margin the gains were tuned for is gone.
pub const LATE_IN_A_ROW: u32 = 3;

/// Judges every tick by the periods that began before its force was ready. Latches; only a restart clears it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Deadline {
    overruns: u32,
    in_a_row: u32,
    released: bool,
}

impl Deadline {
    /// Nothing late yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { overruns: 0, in_a_row: 0, released: false }
    }

    /// Records one finished tick. `periods_late` is 0 when the force was ready within its own period.
    pub fn close(&mut self, periods_late: u32) {
        if periods_late == 0 {
            self.in_a_row = 0;
            return;
        }
        self.overruns = self.overruns.saturating_add(1);
        self.in_a_row = self.in_a_row.saturating_add(1);
        self.released |= self.in_a_row >= LATE_IN_A_ROW;
    }

    /// Whether the force has been released: the core must not run and the output must be zero.
    #[must_use]
    pub const fn released(&self) -> bool {
        self.released
    }

    /// Ticks that ended late since the start.
    #[must_use]
    pub const fn overruns(&self) -> u32 {
        self.overruns
    }
}

#[cfg(test)]
mod tests {
    use super::{Deadline, LATE_IN_A_ROW};

    #[test]
    fn scattered_overruns_are_counted_and_forgiven() {
        let mut deadline = Deadline::new();
        for tick in 0..100 {
            deadline.close(u32::from(tick % LATE_IN_A_ROW != 0)); // two late, one in time
        }
        assert!(!deadline.released());
        assert_eq!(deadline.overruns(), 66);
    }

    #[test]
    fn a_run_of_overruns_releases_for_good() {
        let mut deadline = Deadline::new();
        for _ in 0..LATE_IN_A_ROW {
            assert!(!deadline.released());
            deadline.close(1);
        }
        assert!(deadline.released());
        deadline.close(0);
        assert!(deadline.released(), "a tick in time must not bring the force back");
    }
}
