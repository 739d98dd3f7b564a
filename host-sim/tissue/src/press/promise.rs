//! Checks that a `press` must pass. A run that fails one still writes its files and exits with 1.

use palpate::ClampFlags;

use super::{Hold, Press};
use crate::error::Error;
use crate::machine::processor;
use crate::scene::Drive;

/// Largest accepted deviation of a force from its target at the end of a hold, as a share of the
/// target (1).
const FORCE_TOLERANCE: f64 = 0.02;
impl Press {
    /// Share of ticks that took longer than 1 ms (1).
    fn late_share(&self) -> f64 {
        self.deadline_misses as f64 / self.ticks.len().max(1) as f64
    }

    /// Whether more than one tick in a hundred was late. On a desktop that is a warning: a virtual
    /// machine loses its core for some milliseconds at a time and counts them as its own.
    pub fn often_late(&self) -> bool {
        self.late_share() > 0.01
    }

    /// Checks that the run has no fault, no start inside the tissue and no inverted tet, that no
    /// tick of an emulated board and at most half of a desktop's are late, and that the force at
    /// the holds is positive, rises with depth and, for a force drive, equals its target.
    ///
    /// # Errors
    /// Returns the first check that fails.
    pub fn check(&self, drive: &Drive) -> Result<(), Error> {
        let broken = |what: String| Err(Error::Check(what));
        if let Some(fault) = self.fault {
            let t_s = self.ticks.last().map_or(0.0, |t| t.t_s);
            return broken(format!("{fault} at {t_s:.3} s; the force is zero from there on"));
        }
        if self.ticks.last().is_some_and(|t| t.output.limiters.contains(ClampFlags::BURIED)) {
            return broken(
                "the probe started inside the tissue, or slipped through its surface, and was not outside after that, so there was no force: start it outside, or press less deep".into(),
            );
        }
        // a patch that is too large for a desktop is late in the middle of its times
        let may_be_late = if self.timed_on == processor() { 0.5 } else { 0.0 };
        if self.late_share() > may_be_late {
            return broken(format!(
                "{} of {} ticks took longer than 1 ms: take fewer nodes, or press while the machine does nothing else",
                self.deadline_misses,
                self.ticks.len()
            ));
        }
        if let Some(hold) = self.holds.iter().find(|h| h.min_j <= 0.0) {
            return broken(format!("a tet is inverted at {:.2} mm (J = {:.3})", hold.command_m * 1e3, hold.min_j));
        }
        for hold in &self.holds {
            if hold.force_n <= 0.0 {
                let depth_mm = hold.command_m * 1e3;
                return broken(format!(
                    "no force at {depth_mm:.2} mm: the probe misses the tissue or has slipped through its surface; press where there is tissue, less deep, or refine the mesh there"
                ));
            }
            if matches!(drive, Drive::Force { .. }) && (hold.force_n / hold.target - 1.0).abs() > FORCE_TOLERANCE {
                let (force_n, target, depth_mm) = (hold.force_n, hold.target, hold.command_m * 1e3);
                return broken(format!(
                    "{force_n:.4} N of {target} N at the end of a hold, {depth_mm:.2} mm deep: hold longer or ask for less force"
                ));
            }
        }
        let mut by_depth: Vec<&Hold> = self.holds.iter().collect();
        by_depth.sort_by(|a, b| a.command_m.total_cmp(&b.command_m));
        let falls = |pair: &&[&Hold]| pair[0].command_m < pair[1].command_m && pair[0].force_n >= pair[1].force_n;
        if let Some(pair) = by_depth.windows(2).find(falls) {
            let [a, b] = [pair[0], pair[1]].map(|h| format!("{:.4} N at {:.2} mm", h.force_n, h.command_m * 1e3));
            return broken(format!("the force does not rise with depth: {a}, {b}"));
        }
        Ok(())
    }
}
