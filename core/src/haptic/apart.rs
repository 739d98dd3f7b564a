//! Compares the tip given to the patch with the sensed tip: the last check of whether there may be
//! a force at all.
//!
//! The tick locates the sensed tip ([`crate::stages::presence`]) and gives no force outside the
//! tissue. If that location is outside, the cycle discards any force of the renderer; a force that
//! the renderer still asks for, or that still acts on the hand, for more than [`TICKS`] ticks in a
//! row is a fault. This stage cannot detect a wrong location; the tests check the location with a
//! geometry of their own. It is also a fault if the cycle gives the patch a tip other than the
//! sensed one while a force acts: one that differs by more than the filter of [`super::toggle`]
//! lags along an axis means that the patch computes its force for another place.
//!
//! * in: sensed and shown tip [m], the renderer's answer, the force that acts [N]
//! * out: nothing
//! * cost: about 40 instructions of a Cortex-M4F
//! * failures: [`Fault::TipApart`]

use nalgebra::Vector3;

use super::seen::{Monitor, Seen};
use super::toggle::PAIR;
use crate::fault::Fault;

/// Largest number of ticks in a row in which a force may act while the tip is outside or differs
/// from the sensed one.
/// Source: measured; the walk locates a fast tip up to four ticks late (LIMITS.md).
pub const TICKS: u8 = 5;
/// Rounding error of a position in a workspace of metres [m].
/// Source: derived; single precision resolves 0.12 um between 1 and 2 m; eight times that.
const ROUNDING_M: f32 = 1e-6;

/// Compares the two tips in every tick.
#[derive(Clone, Copy, Debug)]
pub struct Apart {
    lag_m: f32,
    ticks: u8,
}

impl Apart {
    /// Creates the check for a device with this encoder count at the probe [m].
    #[must_use]
    pub fn new(count_m: f32) -> Self {
        Self { lag_m: PAIR * count_m + ROUNDING_M, ticks: 0 }
    }
}

impl Monitor for Apart {
    #[cfg_attr(feature = "stage-cost", inline(never))]
    fn judge(&mut self, seen: &Seen) -> Result<(), Fault> {
        let off_m = seen.position_m - seen.shown_m;
        let lags = !off_m.iter().all(|c| c.abs() <= self.lag_m);
        let asks = seen.output.outside && seen.output.force_n != Vector3::zeros();
        let acts = seen.sent_n != Vector3::zeros();
        self.ticks = if (lags || seen.output.outside) && (acts || asks) { self.ticks.saturating_add(1) } else { 0 };
        if self.ticks > TICKS { Err(Fault::TipApart) } else { Ok(()) }
    }

    fn reset(&mut self) {
        self.ticks = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::haptic::limits::tests::limits;
    use crate::stages::output::Output;

    const FORCE_N: Vector3<f32> = Vector3::new(0.0, 0.0, 1.0);

    /// A tick in which the shown tip lags along y [m].
    fn tick(apart: &mut Apart, lag_m: f32, outside: bool, force_n: Vector3<f32>, sent_n: Vector3<f32>) -> Result<(), Fault> {
        let limits = limits();
        let output = Output { force_n, outside, ..Output::NONE };
        apart.judge(&Seen { shown_m: Vector3::new(0.0, lag_m, 0.0), output, sent_n, ..Seen::none(&limits) })
    }

    /// Number of ticks until the fault.
    fn faults_after(lag_m: f32, outside: bool, force_n: Vector3<f32>, sent_n: Vector3<f32>) -> Option<usize> {
        let mut apart = Apart::new(55e-6);
        (1..100).find(|_| tick(&mut apart, lag_m, outside, force_n, sent_n).is_err())
    }

    #[test]
    fn a_force_outside_is_a_fault_after_five_ticks() {
        assert_eq!(faults_after(0.0, true, FORCE_N, Vector3::zeros()), Some(6), "the renderer goes on asking");
        assert_eq!(faults_after(0.0, true, Vector3::zeros(), FORCE_N), Some(6), "the force goes on acting");
        assert_eq!(faults_after(0.0, true, Vector3::zeros(), Vector3::zeros()), None);
        assert_eq!(faults_after(0.0, false, FORCE_N, FORCE_N), None);
    }

    #[test]
    fn a_shown_tip_that_lags_by_more_than_the_filter_is_a_fault_under_force_alone() {
        assert_eq!(faults_after(83e-6, false, FORCE_N, FORCE_N), None);
        assert_eq!(faults_after(84e-6, false, FORCE_N, FORCE_N), Some(6));
        assert_eq!(faults_after(-84e-6, false, FORCE_N, FORCE_N), Some(6));
        assert_eq!(faults_after(f32::NAN, false, FORCE_N, FORCE_N), Some(6));
        assert_eq!(faults_after(84e-6, false, FORCE_N, Vector3::zeros()), None);
    }

    #[test]
    fn ticks_are_counted_in_a_row() {
        let mut apart = Apart::new(0.0);
        for n in 0..100 {
            let sent_n = if n % 6 == 5 { Vector3::zeros() } else { FORCE_N };
            assert!(tick(&mut apart, 0.0, true, Vector3::zeros(), sent_n).is_ok(), "tick {n}");
        }
        (0..5).for_each(|_| _ = tick(&mut apart, 0.0, true, Vector3::zeros(), FORCE_N));
        apart.reset();
        assert!(tick(&mut apart, 0.0, true, Vector3::zeros(), FORCE_N).is_ok());
    }
}
