//! A probe that speeds up against the force: the force acts the wrong way, or the reading runs the wrong way.
//!
//! With the sign of an actuator or of an encoder wrong, the tissue pulls: the deeper, the stronger. From position alone this is not certain: every
//! motion under `-F` is one under `F` of a hand that pushes `2 F` harder. What can be told is a hand that would have to push harder than hands do.
//! So this asks for much: pushed out by half a newton or more without a break, the probe gained 0.5 m/s inwards. A held device loses its hand at once,
//! a firm hand holds against it; then the force stays within its limit, and saturation halves it.
//!
//! * in: velocity [m/s], normal and force of the contact [N]
//! * out: nothing
//! * cost: 40 instructions of a Cortex-M4F, estimated
//! * may fail: [`Fault::Runaway`]

use nalgebra::Vector3;

use super::length;
use crate::fault::Fault;
use crate::planted::{Defect, planted};

/// Force that a probe does not speed up against [N].
const PUSH_N: f32 = 0.5;
/// Speed gained against it that is a fault [m/s].
const GAINED_M_PER_S: f32 = 0.5;

/// Watches one contact after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Runaway {
    /// Slowest way in since the force is strong, at least zero [m/s].
    slowest_m_per_s: Option<f32>,
}

impl Runaway {
    /// One tick: `applied_n` is the force sent last, along `normal` out of the tissue.
    ///
    /// # Errors
    /// [`Fault::Runaway`].
    pub fn judge(&mut self, velocity_m_per_s: &Vector3<f32>, normal: &Vector3<f32>, applied_n: &Vector3<f32>) -> Result<(), Fault> {
        if length(applied_n) < PUSH_N || applied_n.dot(normal) <= 0.0 {
            self.slowest_m_per_s = None;
            return Ok(());
        }
        let inward = -velocity_m_per_s.dot(normal);
        let inward = if inward > 0.0 { inward } else { 0.0 };
        let slowest = match self.slowest_m_per_s {
            Some(slowest) if slowest < inward => slowest,
            _ => inward,
        };
        self.slowest_m_per_s = Some(slowest);
        match inward - slowest > GAINED_M_PER_S && !planted(Defect::RunawayBorne) {
            true => Err(Fault::Runaway),
            false => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_that_a_tap_brings_is_none_that_is_gained() {
        let judge = |runaway: &mut Runaway, inward: f32, push_n: f32| {
            runaway.judge(&Vector3::new(0.0, 0.0, -inward), &Vector3::z(), &Vector3::new(0.0, 0.0, push_n))
        };
        let mut tap = Runaway::default();
        for n in 0..100_u8 {
            // 1 m/s at the touch, out again with as much
            let inward = 1.0 - 0.02 * f32::from(n);
            assert_eq!(judge(&mut tap, inward, 2.0), Ok(()), "{inward} m/s");
        }
        let mut pulled = Runaway::default();
        let faults = (0..100_u8).position(|n| judge(&mut pulled, 0.06 * f32::from(n), 1.0).is_err());
        assert_eq!(faults, Some(9), "from rest, more than 0.5 m/s");
        let mut weak = Runaway::default();
        assert!((0..100_u8).all(|n| judge(&mut weak, 0.06 * f32::from(n), 0.4).is_ok()), "a weak force holds nobody");
    }
}
