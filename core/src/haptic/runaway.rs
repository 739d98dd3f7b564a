//! A probe that speeds up against the force: the force acts the wrong way, or the reading runs the wrong way.
//!
//! With the sign of an actuator or of an encoder wrong, the tissue pulls: the deeper, the stronger. From position alone this is not certain: every
//! motion under `-F` is one under `F` of a hand that pushes `2 F` harder. What can be told is a hand that would have to push harder than hands do.
//! So this asks for much: pushed out by half a newton or more without a break, the probe gained 0.5 m/s inwards and went 25 mm with it. A light hand
//! loses the device at once, a firm hand holds against it; then the force stays within its limit, and saturation halves it. A hand that suddenly grips
//! four times as hard, 13 N against a device of 3, gains 1 m/s too, but has come to its rest by then. A light handle meets the limit of speed first.
//!
//! * in: way of the tick [m], normal of the contact, force sent last [N]
//! * out: nothing
//! * cost: 60 instructions of a Cortex-M4F, estimated
//! * may fail: [`Fault::Runaway`]

use nalgebra::Vector3;

use crate::fault::Fault;
use crate::planted::{Defect, planted};

/// Force that a probe does not speed up against [N].
const PUSH_N: f32 = 0.5;
/// Speed gained against it that is a fault [m/s].
const GAINED_M_PER_S: f32 = 0.5;
/// Way in while it is gained [m].
const GONE_M: f32 = 25e-3;
/// Share of the newest speed (1): 30 Hz, so that a reading that is held and then made up for is no gain.
const SHARE: f32 = 0.1718;

/// Watches one contact after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Runaway {
    /// Low-passed [m/s].
    velocity_m_per_s: Vector3<f32>,
    /// Slowest way in since the force is strong, at least zero [m/s].
    slowest_m_per_s: Option<f32>,
    /// Way in since then [m].
    gone_m: f32,
}

impl Runaway {
    /// One cycle, `1 / per_s` after the one before: `applied_n` is the force sent last, `normal` points out of the tissue.
    ///
    /// # Errors
    /// [`Fault::Runaway`].
    pub fn judge(
        &mut self,
        way_m: &Vector3<f32>,
        per_s: f32,
        normal: &Vector3<f32>,
        applied_n: &Vector3<f32>,
    ) -> Result<(), Fault> {
        let newest = way_m * per_s;
        self.velocity_m_per_s += (newest - self.velocity_m_per_s) * SHARE;
        if applied_n.dot(applied_n) < PUSH_N * PUSH_N || applied_n.dot(normal) <= 0.0 {
            self.slowest_m_per_s = None;
            return Ok(());
        }
        // speed that was brought along is none that is gained: the low-pass must not still be rising
        if self.slowest_m_per_s.is_none() && newest.dot(normal) < self.velocity_m_per_s.dot(normal) {
            self.velocity_m_per_s = newest;
        }
        let inward = -self.velocity_m_per_s.dot(normal);
        let inward = if inward > 0.0 { inward } else { 0.0 };
        let slowest = match self.slowest_m_per_s {
            Some(slowest) if slowest < inward => slowest,
            _ => {
                self.gone_m = 0.0;
                inward
            }
        };
        self.slowest_m_per_s = Some(slowest);
        self.gone_m -= way_m.dot(normal);
        match inward - slowest > GAINED_M_PER_S && self.gone_m > GONE_M && !planted(Defect::RunawayBorne) {
            true => Err(Fault::Runaway),
            false => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judge(runaway: &mut Runaway, inward: f32, push_n: f32) -> Result<(), Fault> {
        runaway.judge(&Vector3::new(0.0, 0.0, -1e-3 * inward), 1e3, &Vector3::z(), &Vector3::new(0.0, 0.0, push_n))
    }

    #[test]
    fn speed_that_a_tap_brings_is_none_that_is_gained() {
        let mut tap = Runaway::default();
        for _ in 0..100 {
            judge(&mut tap, 1.0, 0.0).unwrap();
        }
        for n in 0..100_u8 {
            // 1 m/s at the touch, out again with as much; one reading is missing and made up for
            let inward = 1.0 - 0.02 * f32::from(n);
            let seen = if n == 5 {
                0.0
            } else if n == 6 {
                2.0 * inward
            } else {
                inward
            };
            assert_eq!(judge(&mut tap, seen, 2.0), Ok(()), "{inward} m/s");
        }
    }

    #[test]
    fn speed_that_grows_up_to_the_touch_is_none_that_is_gained() {
        let mut swung = Runaway::default();
        for n in 0..10_u8 {
            judge(&mut swung, 0.2 * f32::from(n), 0.0).unwrap();
        }
        assert!((0..100).all(|_| judge(&mut swung, 2.0, 2.0).is_ok()));
    }

    #[test]
    fn speed_gained_against_the_force_is_a_fault_against_a_weak_one_it_is_not() {
        let mut pulled = Runaway::default();
        let at = (0..100_u8).position(|n| judge(&mut pulled, 0.06 * f32::from(n), 1.0).is_err());
        assert!(at.is_some_and(|n| (27..31).contains(&n)), "{at:?}: 25 mm are gone at 28");
        let mut gripped = Runaway::default();
        // 6.5 N more at once on 65 g against 540 N/m: 0.7 m/s, and at rest within 25 mm
        assert!((0..100_u8).all(|n| judge(&mut gripped, 0.7 * (0.143 * f32::from(n)).sin(), 1.0).is_ok()));
        let mut weak = Runaway::default();
        assert!((0..100_u8).all(|n| judge(&mut weak, 0.06 * f32::from(n), 0.4).is_ok()), "a weak force holds nobody");
    }
}
