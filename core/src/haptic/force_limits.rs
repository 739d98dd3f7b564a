//! Limits magnitude and growth rate of the output force.
//!
//! The vector is shortened, never clipped per axis, which would turn it. The slew limit applies to
//! growth alone: the part of the last force that the new one no longer contains is dropped at once,
//! and the rest is approached at the slew rate at most. So the limit never makes a force larger
//! than the wanted one and never pushes a hand that leaves; a limit in both directions creates
//! hundreds of millijoules.
//!
//! * in: wanted force, force sent last, cap [N]
//! * out: force [N], and the limits that acted
//! * cost: up to 155 instructions of a Cortex-M4F
//! * failures: [`Fault::ForceNotFinite`], [`Fault::ForceImplausible`]

use nalgebra::Vector3;

use crate::fault::{ClampFlags, Fault};
use crate::haptic::length;
use crate::haptic::seen::{Monitor, Seen, Shaper};

/// Refuses a force of the model that is no number, or far beyond the limit for many ticks.
#[derive(Clone, Copy, Debug, Default)]
pub struct Plausible {
    /// Ticks in a row with an implausible force.
    ticks: u16,
}

impl Monitor for Plausible {
    fn judge(&mut self, seen: &Seen) -> Result<(), Fault> {
        let limits = seen.limits.values();
        let square = seen.output.force_n.dot(&seen.output.force_n);
        if !square.is_finite() {
            return Err(Fault::ForceNotFinite);
        }
        let implausible_n = seen.limits.implausible_n;
        self.ticks = if square > implausible_n * implausible_n { self.ticks.saturating_add(1) } else { 0 };
        match self.ticks >= limits.implausible_ticks {
            true => Err(Fault::ForceImplausible),
            false => Ok(()),
        }
    }

    fn reset(&mut self) {
        *self = Self::default();
    }
}

/// Clamps the model's force to the limit, keeping its direction. This happens *before* damping:
/// while the clamp is active during loading, damping cannot act, so during unloading it must be
/// subtracted from the force that the user feels, not from a much larger force behind the clamp.
#[derive(Clone, Copy, Debug)]
pub struct Longest;

impl Shaper for Longest {
    fn shape(&mut self, force_n: Vector3<f32>, seen: &Seen, flags: &mut ClampFlags) -> Vector3<f32> {
        shorten(force_n, seen.limits.values().max_force_n, flags)
    }

    fn reset(&mut self) {}
}

/// Limits the force to the cap, and its growth since the last tick to the slew limit.
#[derive(Clone, Copy, Debug)]
pub struct Slew;

impl Shaper for Slew {
    fn shape(&mut self, force_n: Vector3<f32>, seen: &Seen, flags: &mut ClampFlags) -> Vector3<f32> {
        let most_n = seen.limits.values().max_force_n;
        let aim_n = shorten(force_n, if seen.cap_n < most_n { seen.cap_n } else { most_n }, flags);
        // the part of the last force that the new one keeps: the nearest point on the segment from
        // zero to the last force
        let square = seen.sent_n.dot(&seen.sent_n);
        let share = if square > 0.0 { (aim_n.dot(&seen.sent_n) / square).clamp(0.0, 1.0) } else { 0.0 };
        let kept_n = seen.sent_n * share;
        let growth_n = aim_n - kept_n;
        let slew_n = seen.limits.slew_n;
        // by squares: the root is taken only where it is needed
        if growth_n.dot(&growth_n) <= slew_n * slew_n {
            return aim_n;
        }
        flags.set(ClampFlags::SLEW);
        kept_n + growth_n * (slew_n / length(&growth_n))
    }

    fn reset(&mut self) {}
}

/// Shortens a force to a length [N], keeping its direction.
fn shorten(force_n: Vector3<f32>, most_n: f32, flags: &mut ClampFlags) -> Vector3<f32> {
    if force_n.dot(&force_n) <= most_n * most_n {
        return force_n;
    }
    flags.set(ClampFlags::FORCE);
    force_n * (most_n / length(&force_n))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::haptic::limits::tests::limits;

    /// Feeds a wanted force to the limit, which sent `sent_n` last.
    fn run(sent_n: &mut Vector3<f32>, wanted: [f32; 3], cap_n: f32) -> Vector3<f32> {
        let limits = limits();
        let seen = Seen { sent_n: *sent_n, cap_n, ..Seen::none(&limits) };
        *sent_n = Slew.shape(wanted.into(), &seen, &mut ClampFlags::default());
        *sent_n
    }

    #[test]
    fn a_long_force_keeps_its_direction() {
        let mut sent_n = Vector3::zeros();
        for _ in 0..20 {
            run(&mut sent_n, [6.0, -2.0, 9.0], 3.0);
        }
        assert!((sent_n - Vector3::new(6.0, -2.0, 9.0) * (3.0 / 11.0)).norm() < 1e-6, "{sent_n}");
    }

    #[test]
    fn it_grows_at_the_slew_and_falls_at_once() {
        let mut sent_n = Vector3::zeros();
        for n in 1..=6_u8 {
            assert!((run(&mut sent_n, [0.0, 0.0, 3.0], 20.0).z - 0.5 * f32::from(n)).abs() < 1e-6);
        }
        assert_eq!(run(&mut sent_n, [0.0, 0.0, 0.2], 20.0), Vector3::new(0.0, 0.0, 0.2));
        run(&mut sent_n, [0.0, 0.0, 0.6], 20.0);
        let other = run(&mut sent_n, [0.0, 0.0, -3.0], 20.0);
        assert_eq!(other, Vector3::new(0.0, 0.0, -0.5), "nothing of the old side is kept");
        assert_eq!(run(&mut sent_n, [0.3, 0.0, 0.0], 20.0), Vector3::new(0.3, 0.0, 0.0));
    }

    #[test]
    fn a_cap_holds() {
        assert!((run(&mut Vector3::zeros(), [1.0, 0.0, 0.0], 0.1).norm() - 0.1).abs() < 1e-7);
    }

    fn judge(plausible: &mut Plausible, force_n: f32) -> Result<(), Fault> {
        let limits = limits();
        let output = crate::Output { force_n: Vector3::new(0.0, 0.0, force_n), ..crate::Output::NONE };
        plausible.judge(&Seen { output, ..Seen::none(&limits) })
    }

    #[test]
    fn an_implausible_force_is_borne_nine_ticks_in_a_row() {
        let mut plausible = Plausible::default();
        for _ in 0..9 {
            assert_eq!(judge(&mut plausible, 16.6), Ok(()));
        }
        assert_eq!(judge(&mut plausible, 16.6), Err(Fault::ForceImplausible));
        assert_eq!(judge(&mut plausible, f32::NAN), Err(Fault::ForceNotFinite));
        plausible.reset();
        for n in 0..1_000 {
            assert_eq!(judge(&mut plausible, if n % 10 == 9 { 1.0 } else { 16.6 }), Ok(()), "tick {n}");
        }
    }
}
