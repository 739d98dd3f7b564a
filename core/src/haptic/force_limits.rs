//! Limits magnitude and growth rate of the output force.
//!
//! The vector is shortened, never clipped per axis, which would turn it. The slew limit applies to
//! growth alone: the part of the last force that the new one no longer contains is dropped at once,
//! and the rest is approached at the slew rate at most. So the limit never makes a force larger
//! than the wanted one and never pushes a hand that leaves; a limit in both directions creates
//! hundreds of millijoules.
//!
//! Under a probe at rest a force has no reason to grow: tissue creeps or settles. A sudden stop
//! makes it ring for up to 0.15 s. But a probe that rests at an edge of the tissue, or whose tip is
//! hardly wider than an element, may lose and regain a foundation point again and again; the force
//! then swings for ever, by newtons at worst, although the hand is given no energy. So from
//! `RINGS_S` after the last count on the force grows at [`RESTING_N_PER_S`] at most: a swing
//! leaves the hand its lowest force, and any other force at rest is as it was. The next count ends
//! this: a count of the reading, not of the position that the patch is shown. The two differ while
//! a count that flips is shown as its mean ([`super::toggle`]), which moves in every tick, so that
//! by the shown position a probe would be at rest no sooner, and later once the flips have ended.
//!
//! * in: wanted force, force sent last, cap [N]; displacement of the tick [m]
//! * out: force [N], and the limits that acted
//! * cost: up to 155 instructions of a Cortex-M4F, and 60 more at rest
//! * failures: [`Fault::ForceNotFinite`], [`Fault::ForceImplausible`]

use nalgebra::Vector3;

use crate::fault::{ClampFlags, Fault};
use crate::haptic::seen::{Monitor, Seen, Shaper};
use crate::haptic::{RINGS_S, length};

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
        // beyond the depth limit a spring of the guard acts besides, which rises with the way; beyond
        // the places of a law, which sets the same flag, the shown tip is the sensed one
        let guarded = seen.output.limiters.contains(ClampFlags::DEPTH) && seen.output.apart_m > 0.0;
        let implausible = square > implausible_n * implausible_n && !guarded;
        self.ticks = if implausible { self.ticks.saturating_add(1) } else { 0 };
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

/// Largest growth of the force under a probe at rest [N/s].
/// Source: derived; a force that rises for half a period at 8 Hz then swings by 6 mN, a fifth of
/// the 30 mN that a bare finger notices on such devices (DECISIONS.md).
pub const RESTING_N_PER_S: f32 = 0.1;

/// Limits the force to the cap, and its growth since the last tick to the slew limit.
#[derive(Clone, Copy, Debug)]
pub struct Slew {
    /// Ticks without a count, and those after which the probe is at rest.
    still_ticks: u16,
    ring_ticks: u16,
    /// Largest growth per tick at rest [N].
    resting_n: f32,
    /// Force of the last tick, before cap and slew limit [N].
    calm_n: Vector3<f32>,
}

impl Slew {
    /// Creates the limit for a loop with this tick [s].
    #[must_use]
    pub fn build(tick_s: f32) -> Self {
        let ring_ticks = (RINGS_S / tick_s) as u16;
        Self { still_ticks: 0, ring_ticks, resting_n: RESTING_N_PER_S * tick_s, calm_n: Vector3::zeros() }
    }
}

impl Shaper for Slew {
    fn shape(&mut self, force_n: Vector3<f32>, seen: &Seen, flags: &mut ClampFlags) -> Vector3<f32> {
        let moved = seen.displacement_m != Vector3::zeros();
        self.still_ticks = if moved { 0 } else { self.still_ticks.saturating_add(1) };
        let rests = self.still_ticks > self.ring_ticks;
        self.calm_n = if rests { grown(&self.calm_n, force_n, self.resting_n, flags) } else { force_n };
        let most_n = seen.limits.values().max_force_n;
        let aim_n = shorten(self.calm_n, if seen.cap_n < most_n { seen.cap_n } else { most_n }, flags);
        grown(&seen.sent_n, aim_n, seen.limits.slew_n, flags)
    }

    fn reset(&mut self) {
        self.still_ticks = 0;
    }
}

/// The force `aim_n`, or one on the way to it that has grown from `last_n` by `slew_n` [N].
#[inline(never)] // two copies would take more of the board's flash
fn grown(last_n: &Vector3<f32>, aim_n: Vector3<f32>, slew_n: f32, flags: &mut ClampFlags) -> Vector3<f32> {
    // the part of the last force that the new one keeps: the nearest point on the segment from zero
    // to the last force
    let square = last_n.dot(last_n);
    let share = if square > 0.0 { (aim_n.dot(last_n) / square).clamp(0.0, 1.0) } else { 0.0 };
    let kept_n = last_n * share;
    let growth_n = aim_n - kept_n;
    // by squares: the root is taken only where it is needed
    if growth_n.dot(&growth_n) <= slew_n * slew_n {
        return aim_n;
    }
    flags.set(ClampFlags::SLEW);
    kept_n + growth_n * (slew_n / length(&growth_n))
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
    extern crate std;
    use super::*;
    use crate::haptic::limits::tests::limits;

    /// Feeds a wanted force to the limit, which sent `sent_n` last.
    fn run(sent_n: &mut Vector3<f32>, wanted: [f32; 3], cap_n: f32) -> Vector3<f32> {
        let limits = limits();
        let seen = Seen { sent_n: *sent_n, cap_n, ..Seen::none(&limits) };
        *sent_n = Slew::build(1e-3).shape(wanted.into(), &seen, &mut ClampFlags::default());
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

    const COUNT: Vector3<f32> = Vector3::new(0.0, 55e-6, 0.0);

    /// Forces for a wanted force per tick [N]. The probe moves by a count in every
    /// tick whose number is a multiple of `every`.
    fn held(ticks: u16, every: u16, wanted_n: impl Fn(f32) -> f32) -> std::vec::Vec<f32> {
        let (limits, mut slew, mut sent_n) = (limits(), Slew::build(1e-3), Vector3::zeros());
        (0..ticks)
            .map(|n| {
                let displacement_m = if n.is_multiple_of(every) { COUNT } else { Vector3::zeros() };
                let seen = Seen { sent_n, displacement_m, ..Seen::none(&limits) };
                let wanted_n = Vector3::new(0.6, 0.0, 0.8) * wanted_n(f32::from(n));
                sent_n = slew.shape(wanted_n, &seen, &mut ClampFlags::default());
                sent_n.norm()
            })
            .collect()
    }

    /// Difference between the largest and the smallest force [N].
    fn range_n(forces_n: &[f32]) -> f32 {
        let last = forces_n.iter();
        last.clone().fold(f32::MIN, |a, b| a.max(*b)) - last.fold(f32::MAX, |a, b| a.min(*b))
    }

    #[test]
    fn a_force_that_swings_at_rest_becomes_its_lowest() {
        for half_ticks in [1.0, 2.0, 9.0, 30.0, 60.0] {
            let up = |n: f32| ((n / half_ticks) as u32).is_multiple_of(2);
            let forces_n = held(2_000, 10_000, |n| if up(n) { 1.5 } else { 0.5 });
            let range_n = range_n(&forces_n[400..]);
            assert!(range_n <= 0.1e-3 * half_ticks + 1e-6, "{half_ticks} ticks: {range_n}");
            assert!((forces_n[1_999] - 0.5).abs() < 0.01, "{half_ticks} ticks");
            let moved_n = held(2_000, 190, |n| if up(n) { 1.5 } else { 0.5 });
            assert!(self::range_n(&moved_n) > 0.49, "a hand that moves feels what the tissue does");
        }
    }

    #[test]
    fn a_force_that_turns_to_and_fro_at_rest_becomes_what_both_have() {
        let (limits, mut slew, mut sent_n) = (limits(), Slew::build(1e-3), Vector3::zeros());
        let mut last = std::vec::Vec::new();
        for n in 0..2_000_u16 {
            let wanted_n =
                if (n / 7).is_multiple_of(2) { Vector3::new(-0.17, -0.37, 0.56) } else { Vector3::new(-0.02, -0.36, 0.35) };
            let seen = Seen { sent_n, ..Seen::none(&limits) };
            sent_n = slew.shape(wanted_n, &seen, &mut ClampFlags::default());
            if n >= 400 {
                last.push(sent_n);
            }
        }
        // from swing to swing; the force still turns slowly to what both have
        for swings in last.chunks(28) {
            let range = |axis: usize| range_n(&swings.iter().map(|force_n| force_n[axis]).collect::<std::vec::Vec<_>>());
            assert!((0..3).all(|axis| range(axis) < 5e-3), "{swings:?}");
        }
        assert!(sent_n.norm() > 0.45, "{sent_n}");
    }

    #[test]
    fn a_force_that_creeps_settles_or_rings_after_a_stop_stays() {
        for (name, wanted_n) in [
            ("creep", (|n| 1.0 + libm::expf(-n / 300.0)) as fn(f32) -> f32),
            ("recovery", |n| 1.0 - 0.05 * libm::expf(-n / 2_000.0)),
            ("ring", |n| 1.0 + 0.3 * libm::expf(-n / 20.0) * libm::sinf(core::f32::consts::PI * n / 4.0)),
        ] {
            let forces_n = held(2_000, 10_000, wanted_n);
            let off = forces_n.iter().enumerate().skip(10).map(|(n, force_n)| (force_n - wanted_n(n as f32)).abs());
            let off_n = off.fold(0.0, f32::max);
            assert!(off_n < 0.5e-3, "{name}: {off_n} N");
        }
    }

    #[test]
    fn a_count_ends_the_rest_and_a_late_tick_does_not_halve_it_for_good() {
        let forces_n = held(1_001, 1_000, |n| if n > 500.0 { 2.0 } else { 1.0 });
        assert!((forces_n[999] - 1.05).abs() < 1e-3, "half a second at rest: {}", forces_n[999]);
        assert!((forces_n[1_000] - 1.55).abs() < 1e-3, "the slew limit again: {}", forces_n[1_000]);
        let (limits, mut slew, mut sent_n) = (limits(), Slew::build(1e-3), Vector3::zeros());
        for n in 0..=600_u16 {
            let cap_n = if n == 500 { 0.5 } else { 3.0 };
            let seen = Seen { sent_n, cap_n, ..Seen::none(&limits) };
            sent_n = slew.shape(Vector3::new(0.0, 0.0, 1.0), &seen, &mut ClampFlags::default());
            assert_eq!(sent_n.z, if n == 0 || n == 500 { 0.5 } else { 1.0 }, "tick {n}");
        }
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
