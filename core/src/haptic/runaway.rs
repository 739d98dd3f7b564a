//! Detects a probe that speeds up against the force, because an actuator or an encoder has the
//! wrong sign.
//!
//! With a wrong sign the tissue pulls, and pulls harder the deeper the probe is. Position alone
//! cannot prove it: every motion under `-F` is also the motion under `F` of a hand that pushes
//! `2 F` harder. Only a motion that hands do not make can be recognised. So the thresholds are
//! high: against a force of at least 0.5 N the probe gains 0.5 m/s, and meanwhile travels 25 mm
//! straight into the tissue. A light hand loses the device at once. A firm hand holds against the
//! pull; the force then stays within its limit, and saturation halves it. A hand that suddenly
//! grips four times as hard, 13 N against a device of 3 N, gains 1 m/s too, but comes to rest
//! within the 25 mm. A light handle exceeds the speed limit first.
//!
//! Speed and travel are measured along the normal at the moment when the probe was slowest. The
//! normal of this tick would not do: a probe that slides while pressed pushes tissue up in front of
//! it, the normal tilts against the motion by up to 60 degrees, and a constant speed along the
//! surface would look like speed gained into the tissue. Such a slide stays at an angle to every
//! normal, even while it speeds up; a force of the wrong sign drives the probe straight along it.
//!
//! The velocity is low-passed here once more: that of the damping follows a turn within a count, so
//! a held reading and the double displacement after it would look like speed gained.
//!
//! * in: displacement of the tick [m], normal of the contact, force sent last [N]
//! * out: nothing
//! * cost: 75 instructions of a Cortex-M4F, estimated
//! * failures: [`Fault::Runaway`]

use nalgebra::Vector3;

use super::damping::DampingSettings;
use super::device::DeviceSpec;
use super::seen::{Monitor, Seen};
use crate::fault::Fault;

/// Least force against which a gain in speed counts [N]: below it any wiring is permitted.
const PUSH_N: f32 = DeviceSpec::UNCOMMISSIONED_N;
/// Gain in speed against the force that is a fault [m/s].
/// Source: derived; half of the 1 m/s that a grip of 13 N gains against 3 N (DECISIONS.md)
/// (`half_a_metre_per_second_gained_against_half_a_newton_is_a_fault`).
const GAINED_M_PER_S: f32 = 0.5;
/// Least travel into the tissue during that gain [m].
/// Source: measured; a grip that closes with 13 N against 3 N gains 1 m/s within 20 mm
/// (DECISIONS.md). At 17 mm
/// `a_hand_that_comes_to_rest_within_twenty_five_millimetres_is_no_runaway` fails.
const GONE_M: f32 = 25e-3;
/// Square of the least cosine between that travel and the normal (1): within 26 degrees.
/// Source: measured; pressed slides tilt the normal by up to 60 degrees and stay further from it
/// (`pressed_slides_up_to_the_speed_limit_are_no_fault`). At 0.6
/// `a_slow_slide_that_gets_faster_at_an_angle_to_its_normal_is_no_fault` fails, at 0.95
/// `a_wrong_sign_after_a_long_slide_is_told_from_the_slide`.
const STRAIGHT: f32 = 0.81;
/// Share of the newest velocity in the low-pass (1), so that a held reading followed by a double
/// displacement does not count as speed gained.
const SHARE: f32 = DampingSettings::SHARE_30_HZ;

/// The moment from which the gain in speed is measured.
#[derive(Clone, Copy, Debug)]
struct Slowest {
    /// Surface normal in the tick in which the probe was slowest.
    normal: Vector3<f32>,
    /// Speed into the tissue in that tick, at least zero [m/s].
    inward_m_per_s: f32,
    /// Displacement since that tick [m].
    gone_m: Vector3<f32>,
}

/// Watches the contacts, one after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Runaway {
    /// Low-passed velocity of the probe [m/s].
    velocity_m_per_s: Vector3<f32>,
    /// State since the force exceeded [`PUSH_N`].
    slowest: Option<Slowest>,
}

impl Monitor for Runaway {
    fn judge(&mut self, seen: &Seen) -> Result<(), Fault> {
        let normal = &seen.output.normal;
        let newest = seen.displacement_m * seen.per_s;
        self.velocity_m_per_s += (newest - self.velocity_m_per_s) * SHARE;
        if seen.sent_n.dot(&seen.sent_n) < PUSH_N * PUSH_N || seen.sent_n.dot(normal) <= 0.0 {
            self.slowest = None;
            return Ok(());
        }
        // the probe arrives with a speed that the low-pass has not reached yet: the difference does
        // not count as speed gained
        if self.slowest.is_none() && newest.dot(normal) < self.velocity_m_per_s.dot(normal) {
            self.velocity_m_per_s = newest;
        }
        if let Some(slowest) = &mut self.slowest {
            slowest.gone_m += seen.displacement_m;
            let gained = -self.velocity_m_per_s.dot(&slowest.normal) - slowest.inward_m_per_s;
            if gained > 0.0 {
                let gone_m = -slowest.gone_m.dot(&slowest.normal);
                let straight = gone_m * gone_m > STRAIGHT * slowest.gone_m.dot(&slowest.gone_m);
                return match gained > GAINED_M_PER_S && gone_m > GONE_M && straight {
                    true => Err(Fault::Runaway),
                    false => Ok(()),
                };
            }
        }
        let inward = -self.velocity_m_per_s.dot(normal);
        let inward_m_per_s = if inward > 0.0 { inward } else { 0.0 };
        self.slowest = Some(Slowest { normal: *normal, inward_m_per_s, gone_m: Vector3::zeros() });
        Ok(())
    }

    fn reset(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tick at a velocity [m/s] against a force [N].
    fn tick(
        runaway: &mut Runaway,
        velocity_m_per_s: Vector3<f32>,
        normal: Vector3<f32>,
        sent_n: Vector3<f32>,
    ) -> Result<(), Fault> {
        let limits = crate::haptic::limits::tests::limits();
        let output = crate::Output { normal, ..crate::Output::NONE };
        let displacement_m = velocity_m_per_s * 1e-3;
        runaway.judge(&Seen { displacement_m, output, sent_n, ..Seen::none(&limits) })
    }

    fn judge(runaway: &mut Runaway, inward: f32, push_n: f32) -> Result<(), Fault> {
        tick(runaway, Vector3::new(0.0, 0.0, -inward), Vector3::z(), Vector3::new(0.0, 0.0, push_n))
    }

    #[test]
    fn speed_that_a_tap_brings_is_none_that_is_gained() {
        let mut tap = Runaway::default();
        for _ in 0..100 {
            judge(&mut tap, 1.0, 0.0).unwrap();
        }
        for n in 0..100_u8 {
            // 1 m/s at the touch, out again at the same speed; one reading is missing and made up
            // for
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
        // a grip that is suddenly 6.5 N stronger, on 65 g against 540 N/m: 0.7 m/s, and at rest
        // within 25 mm
        assert!((0..100_u8).all(|n| judge(&mut gripped, 0.7 * (0.143 * f32::from(n)).sin(), 1.0).is_ok()));
        let mut weak = Runaway::default();
        assert!((0..100_u8).all(|n| judge(&mut weak, 0.06 * f32::from(n), 0.4).is_ok()), "a weak force holds nobody");
    }

    /// A probe at 1.45 m/s along the surface, reached at `m_per_s2`, while the normal tilts against
    /// the motion to `tilt` within 20 ms, as in a pressed slide.
    fn slide(m_per_s2: f32, tilt: f32) -> bool {
        let mut slid = Runaway::default();
        (0..200_u8).all(|n| {
            let tilted = tilt * (f32::from(n) / 20.0).min(1.0);
            let normal = Vector3::new(-libm::sinf(tilted), 0.0, libm::cosf(tilted));
            let speed = (m_per_s2 * 1e-3 * f32::from(n)).min(1.45);
            tick(&mut slid, Vector3::new(speed, 0.0, 0.0), normal, normal * 3.0).is_ok()
        })
    }

    #[test]
    fn a_normal_that_tilts_against_a_slide_is_no_gain_of_speed() {
        for tilt in [0.3, 0.6, 0.9, 1.05] {
            for m_per_s2 in [20.0, 60.0, 1e4] {
                assert!(slide(m_per_s2, tilt), "{tilt} rad, {m_per_s2} m/s^2");
            }
        }
    }

    #[test]
    fn a_wrong_sign_after_a_long_slide_is_told_from_the_slide() {
        let mut slid = Runaway::default();
        let normal = Vector3::new(-0.6, 0.0, 0.8);
        for _ in 0..300 {
            tick(&mut slid, Vector3::x(), normal, normal * 2.0).unwrap();
        }
        let pulled = |n: u8| Vector3::x() - normal * (6e-2 * f32::from(n));
        let at = (0..100_u8).position(|n| tick(&mut slid, pulled(n), normal, normal * 2.0).is_err());
        assert!(at.is_some_and(|n| n < 50), "{at:?}");
    }

    #[test]
    fn a_gain_of_six_tenths_is_a_fault_and_of_four_tenths_is_not() {
        for (gained, fault) in [(0.6_f32, true), (0.4, false)] {
            let mut pulled = Runaway::default();
            let found = (0..100_u8).any(|n| judge(&mut pulled, (0.06 * f32::from(n)).min(gained), 1.0).is_err());
            assert_eq!(found, fault, "{gained} m/s");
        }
    }

    #[test]
    fn a_force_into_the_tissue_is_not_one_that_should_hold_the_probe() {
        let mut sucked = Runaway::default();
        assert!((0..100_u8).all(|n| judge(&mut sucked, 0.06 * f32::from(n), -1.0).is_ok()));
    }

    #[test]
    fn a_slow_slide_that_gets_faster_at_an_angle_to_its_normal_is_no_fault() {
        for tilt in [0.3, 0.6, 0.9, 1.05] {
            let (mut slid, mut speed) = (Runaway::default(), 0.3_f32);
            let normal = Vector3::new(-libm::sinf(tilt), 0.0, libm::cosf(tilt));
            for n in 0..250_u8 {
                speed = if n < 100 { 0.3 } else { (speed + 0.02).min(1.45) };
                let answer = tick(&mut slid, Vector3::new(speed, 0.0, 0.0), normal, normal * 3.0);
                assert_eq!(answer, Ok(()), "{tilt} rad, tick {n}");
            }
        }
    }
}
