//! Limits magnitude and growth rate of the output force.
//!
//! The vector is shortened, never clipped per axis, which would turn it. The slew limit applies to
//! growth alone: the part of the last force that the new one no longer contains is dropped at once,
//! and the rest is approached at the slew rate at most. So the limit never makes a force larger
//! than the wanted one and never pushes a hand that leaves; a limit in both directions creates
//! hundreds of millijoules.
//!
//! * in: wanted force [N], cap [N]
//! * out: force [N], and the limits that acted
//! * cost: up to 155 instructions of a Cortex-M4F
//! * failures: [`Fault::ForceNotFinite`], [`Fault::ForceImplausible`]

use nalgebra::Vector3;

use super::LoopLimits;
use crate::fault::{ClampFlags, Fault};
use crate::haptic::length;

/// A limited force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limited {
    /// Force on the hand after the limits, patch frame [N].
    pub force_n: Vector3<f32>,
    /// Limits that changed the force: [`ClampFlags::FORCE`], [`ClampFlags::SLEW`].
    pub limiters: ClampFlags,
}

/// Limits the force and watches for implausible and for saturated forces.
#[derive(Clone, Copy, Debug, Default)]
pub struct ForceLimiter {
    last_n: Vector3<f32>,
    implausible: u16,
    saturated: u16,
}

impl ForceLimiter {
    /// Checks the model's force once per tick, before any gain.
    ///
    /// # Errors
    /// [`Fault::ForceNotFinite`] at once, [`Fault::ForceImplausible`] if it stays far too large.
    pub fn judge(&mut self, limits: &LoopLimits, model_n: &Vector3<f32>) -> Result<(), Fault> {
        let square = model_n.dot(model_n);
        if !square.is_finite() {
            return Err(Fault::ForceNotFinite);
        }
        let most_n = limits.values.max_force_n;
        let implausible_n = limits.implausible_n;
        self.implausible = if square > implausible_n * implausible_n { self.implausible.saturating_add(1) } else { 0 };
        // the model's force at the limit counts as saturated, too
        self.saturated = if square >= 0.998 * (most_n * most_n) { self.saturated.saturating_add(1) } else { 0 };
        match self.implausible >= limits.values.implausible_ticks {
            true => Err(Fault::ForceImplausible),
            false => Ok(()),
        }
    }

    /// Clamps the model's force to the limit [N], keeping its direction; returns the force and
    /// whether it was clamped. This happens *before* damping: while the clamp is active during
    /// loading, damping cannot act, so during unloading it must be subtracted from the force that
    /// the user feels, not from a much larger force behind the clamp.
    #[must_use]
    pub fn shorten(limits: &LoopLimits, model_n: &Vector3<f32>) -> (Vector3<f32>, bool) {
        let (square, most_n) = (model_n.dot(model_n), limits.values.max_force_n);
        match square > most_n * most_n {
            true => (model_n * (most_n / length(model_n)), true),
            false => (*model_n, false),
        }
    }

    /// Returns the force to apply: no larger than the limit and `cap_n`, grown by no more than the
    /// slew limit allows.
    ///
    /// # Errors
    /// Fails with [`Fault::ForceNotFinite`] if the force or its cap is not finite.
    pub fn limit(&mut self, limits: &LoopLimits, wanted_n: Vector3<f32>, cap_n: f32) -> Result<Limited, Fault> {
        let mut limiters = ClampFlags::default();
        let square = wanted_n.dot(&wanted_n);
        if !(square.is_finite() && cap_n.is_finite()) {
            return Err(Fault::ForceNotFinite);
        }
        let most_n = if cap_n < limits.values.max_force_n { cap_n } else { limits.values.max_force_n };
        let mut aim_n = wanted_n;
        if square > most_n * most_n {
            aim_n *= most_n / length(&wanted_n);
            limiters.set(ClampFlags::FORCE);
        }
        // the part of the last force that the new one keeps: the nearest point on the segment from
        // zero to the last force
        let square = self.last_n.dot(&self.last_n);
        let share = if square > 0.0 { (aim_n.dot(&self.last_n) / square).clamp(0.0, 1.0) } else { 0.0 };
        let kept_n = self.last_n * share;
        let growth_n = aim_n - kept_n;
        // by squares: the root is taken only where it is needed
        if growth_n.dot(&growth_n) > limits.slew_n * limits.slew_n {
            aim_n = kept_n + (aim_n - kept_n) * (limits.slew_n / length(&growth_n));
            limiters.set(ClampFlags::SLEW);
        }
        self.last_n = aim_n;
        Ok(Limited { force_n: aim_n, limiters })
    }

    /// Sets the force to zero at once.
    pub fn release(&mut self) {
        *self = Self::default();
    }

    /// Force that was output last [N].
    #[must_use]
    pub fn last_n(&self) -> Vector3<f32> {
        self.last_n
    }

    /// Whether the model's force was at the limit for longer than `saturated_ticks`.
    #[must_use]
    pub fn strained(&self, limits: &LoopLimits) -> bool {
        self.saturated > limits.values.saturated_ticks
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::limits;
    use super::*;

    fn run(limiter: &mut ForceLimiter, wanted: [f32; 3]) -> Vector3<f32> {
        limiter.limit(&limits(), wanted.into(), 20.0).unwrap().force_n
    }

    #[test]
    fn a_long_force_keeps_its_direction() {
        let mut limiter = ForceLimiter::default();
        let force_n = (0..20).fold(Vector3::zeros(), |_, _| run(&mut limiter, [6.0, -2.0, 9.0]));
        assert!((force_n - Vector3::new(6.0, -2.0, 9.0) * (3.0 / 11.0)).norm() < 1e-6, "{force_n}");
    }

    #[test]
    fn it_grows_at_the_slew_and_falls_at_once() {
        let mut limiter = ForceLimiter::default();
        for n in 1..=6_u8 {
            assert!((run(&mut limiter, [0.0, 0.0, 3.0]).z - 0.5 * f32::from(n)).abs() < 1e-6);
        }
        assert_eq!(run(&mut limiter, [0.0, 0.0, 0.2]), Vector3::new(0.0, 0.0, 0.2));
        run(&mut limiter, [0.0, 0.0, 0.6]);
        assert_eq!(run(&mut limiter, [0.0, 0.0, -3.0]), Vector3::new(0.0, 0.0, -0.5), "nothing of the old side is kept");
        assert_eq!(run(&mut limiter, [0.3, 0.0, 0.0]), Vector3::new(0.3, 0.0, 0.0));
    }

    #[test]
    fn a_cap_holds_and_what_is_no_number_is_a_fault() {
        let mut limiter = ForceLimiter::default();
        assert!((limiter.limit(&limits(), Vector3::x(), 0.1).unwrap().force_n.norm() - 0.1).abs() < 1e-7);
        for (bad, cap_n) in [(f32::NAN, 1.0), (f32::INFINITY, 1.0), (3e38, 1.0), (0.0, f32::NAN)] {
            assert_eq!(limiter.limit(&limits(), Vector3::new(0.0, bad, 0.0), cap_n), Err(Fault::ForceNotFinite));
        }
    }

    #[test]
    fn an_implausible_force_is_borne_nine_ticks_and_saturation_is_told() {
        let (limits, mut limiter) = (limits(), ForceLimiter::default());
        for _ in 0..9 {
            assert_eq!(limiter.judge(&limits, &Vector3::new(0.0, 0.0, 15.1)), Ok(()));
        }
        assert_eq!(limiter.judge(&limits, &Vector3::new(0.0, 0.0, 15.1)), Err(Fault::ForceImplausible));
        assert_eq!(limiter.judge(&limits, &Vector3::new(0.0, f32::NAN, 0.0)), Err(Fault::ForceNotFinite));
        limiter.release();
        for n in 0..=200 {
            assert!(!limiter.strained(&limits), "tick {n}");
            limiter.judge(&limits, &Vector3::new(0.0, 3.0, 0.0)).unwrap();
        }
        assert!(limiter.strained(&limits));
        limiter.judge(&limits, &Vector3::new(0.0, 2.0, 0.0)).unwrap();
        assert!(!limiter.strained(&limits));
    }

    #[test]
    fn implausible_forces_are_a_fault_only_in_a_row() {
        let (limits, mut limiter) = (limits(), ForceLimiter::default());
        for n in 0..1_000 {
            let force_n = if n % 10 == 9 { 1.0 } else { 15.1 };
            assert_eq!(limiter.judge(&limits, &Vector3::new(0.0, 0.0, force_n)), Ok(()), "tick {n}");
        }
    }

    #[test]
    fn after_a_release_the_force_grows_from_zero() {
        let mut limiter = ForceLimiter::default();
        for _ in 0..10 {
            run(&mut limiter, [0.0, 0.0, 3.0]);
        }
        limiter.release();
        assert_eq!(limiter.last_n(), Vector3::zeros());
        assert!((run(&mut limiter, [0.0, 0.0, 3.0]).z - 0.5).abs() < 1e-6);
    }
}
