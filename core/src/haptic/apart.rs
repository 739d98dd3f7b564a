//! Compares the tip given to the patch with the sensed tip: the last check of whether there may be
//! a force at all.
//!
//! The tick locates the sensed tip ([`crate::stages::presence`]) and gives no force outside the
//! tissue. If that location is outside, this stage discards any force of the renderer; a force that
//! the renderer still asks for, or that still acts on the hand, for more than [`TICKS`] ticks in a
//! row is a fault. This stage cannot detect a wrong location; the tests check the location with a
//! geometry of their own. It is also a fault if the cycle gives the patch a tip other than the
//! sensed one while a force acts. The filter of [`super::toggle`] lags by at most 1.3 counts per
//! axis, so a difference of more than two counts means that the patch computes its force for
//! another place.
//!
//! * in: sensed and shown tip [m], the renderer's answer, the force that acts [N]
//! * out: whether a force may be felt
//! * cost: about 40 instructions of a Cortex-M4F
//! * failures: [`Fault::TipApart`]

use nalgebra::Vector3;

use crate::fault::Fault;
use crate::stages::output::Output;

/// Largest number of ticks in a row in which a force may act while the tip is outside or differs
/// from the sensed one.
pub const TICKS: u8 = 5;
/// Largest lag of the shown tip behind the sensed one, per axis [counts].
const LAG_COUNTS: f32 = 2.0;
/// Rounding error of a position in a workspace of metres [m].
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
        Self { lag_m: LAG_COUNTS * count_m + ROUNDING_M, ticks: 0 }
    }

    /// Resets the count of ticks.
    pub fn reset(&mut self) {
        self.ticks = 0;
    }

    /// Returns whether a force may be output; `acting_n` is the force that was output last [N].
    ///
    /// # Errors
    /// Fails with [`Fault::TipApart`] if, for more than [`TICKS`] ticks in a row, a force acts or
    /// is requested although the tip is outside or the shown tip differs from the sensed one.
    #[cfg_attr(feature = "stage-cost", inline(never))]
    pub fn judge(
        &mut self,
        sensed_m: &Vector3<f32>,
        shown_m: &Vector3<f32>,
        output: &Output,
        acting_n: &Vector3<f32>,
    ) -> Result<bool, Fault> {
        let off_m = sensed_m - shown_m;
        let lags = !off_m.iter().all(|c| c.abs() <= self.lag_m);
        let asks = output.outside && output.force_n != Vector3::zeros();
        let acts = *acting_n != Vector3::zeros();
        self.ticks = if (lags || output.outside) && (acts || asks) { self.ticks.saturating_add(1) } else { 0 };
        if self.ticks > TICKS { Err(Fault::TipApart) } else { Ok(!output.outside) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORCE_N: Vector3<f32> = Vector3::new(0.0, 0.0, 1.0);

    /// Number of ticks until the fault.
    fn faults_after(lag_m: f32, outside: bool, force_n: Vector3<f32>, acting_n: Vector3<f32>) -> Option<usize> {
        let mut apart = Apart::new(55e-6);
        let output = Output { force_n, outside, ..Output::NONE };
        (1..100).find(|_| apart.judge(&Vector3::zeros(), &Vector3::new(0.0, lag_m, 0.0), &output, &acting_n).is_err())
    }

    #[test]
    fn a_force_outside_is_dropped_at_once_and_a_fault_after_five_ticks() {
        let output = Output { force_n: FORCE_N, outside: true, ..Output::NONE };
        let at = Vector3::zeros();
        assert_eq!(Apart::new(0.0).judge(&at, &at, &output, &FORCE_N), Ok(false));
        assert_eq!(Apart::new(0.0).judge(&at, &at, &Output { outside: false, ..output }, &FORCE_N), Ok(true));
        assert_eq!(faults_after(0.0, true, FORCE_N, Vector3::zeros()), Some(6), "the renderer goes on asking");
        assert_eq!(faults_after(0.0, true, Vector3::zeros(), FORCE_N), Some(6), "the force goes on acting");
        assert_eq!(faults_after(0.0, true, Vector3::zeros(), Vector3::zeros()), None);
        assert_eq!(faults_after(0.0, false, FORCE_N, FORCE_N), None);
    }

    #[test]
    fn a_shown_tip_that_lags_by_more_than_two_counts_is_a_fault_under_force_alone() {
        assert_eq!(faults_after(109e-6, false, FORCE_N, FORCE_N), None);
        assert_eq!(faults_after(112e-6, false, FORCE_N, FORCE_N), Some(6));
        assert_eq!(faults_after(-112e-6, false, FORCE_N, FORCE_N), Some(6));
        assert_eq!(faults_after(f32::NAN, false, FORCE_N, FORCE_N), Some(6));
        assert_eq!(faults_after(112e-6, false, FORCE_N, Vector3::zeros()), None);
    }

    #[test]
    fn ticks_are_counted_in_a_row() {
        let (mut apart, at) = (Apart::new(0.0), Vector3::zeros());
        let outside = Output { outside: true, ..Output::NONE };
        for n in 0..100 {
            let acting_n = if n % 6 == 5 { Vector3::zeros() } else { FORCE_N };
            assert!(apart.judge(&at, &at, &outside, &acting_n).is_ok(), "tick {n}");
        }
        (0..5).for_each(|_| _ = apart.judge(&at, &at, &outside, &FORCE_N));
        apart.reset();
        assert!(apart.judge(&at, &at, &outside, &FORCE_N).is_ok());
    }
}
