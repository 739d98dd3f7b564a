//! Damping in proportion to the patch's own tangent stiffness, in contact only.
//!
//! A sampled wall of stiffness `K` and virtual damping `B` is passive in every passive hand if the
//! device itself has the damping `b > K T / 2 + |B|` (Colgate and Schenkel, Passivity of a class of
//! sampled-data systems, J. Robotic Systems 14, 1997). The first term is the negative damping of a
//! force that is held for a tick; a delay of `d` ticks adds `K d T`. The second is what virtual
//! damping costs: at the frequency `w` the condition is `b + B cos(w T) > K T / 2`, so `B` helps
//! below a quarter of the sampling rate and harms above it, most at half of it. No desktop device
//! has such a `b`: 0.1 N s/m are enough for 67 N/m at one tick of delay.
//!
//! Our `B` is `tau K` with `tau = 2 (d + 1/2) T`: half of it cancels the negative damping at low
//! frequencies, and the other half damps. It breaks that condition, and is used all the same,
//! because a hand moves tissue far below 250 Hz, and the low-pass of 30 Hz fades `B` before it
//! harms. What this leaves open is measured (`palpate stability --loop`). The bound on the energy
//! does not rest on damping but on [`super::account`]. A constant damping would have to be chosen
//! for the stiffest contact and would double the force of a tap on soft tissue, whereas the tangent
//! stiffness vanishes at first touch.
//!
//! ```text
//! K = 3/2 F / max(depth, 0.3 mm)                        (Hertz), or the model's own tangent
//! b = min(tau K + b0 min(1, F / 0.1 N), 20 N s/m)
//! F_n = max(0, F + b u)                                 u = low-passed speed into the tissue
//! ```
//!
//! In three dimensions, the part along the contact normal is damped: the low-passed velocity
//! *vector* is projected on the normal of this tick, so a normal that turns needs no state. A probe
//! with friction is damped along the surface as well, because where it sticks the tissue is about
//! as stiff in that direction. The force along the surface is limited to what friction can carry,
//! so that a probe that slips feels friction alone. Without friction, a force along the surface is
//! passed on as it is.
//!
//! * in: position each tick [m]; force, normal, depth of the patch
//! * out: force [N]; exactly that of the patch when the probe is at rest, exactly zero without
//!   contact, never pulling
//! * cost: 140 instructions of a Cortex-M4F
//! * failures: none; NaN in gives NaN out, which the limits refuse

use nalgebra::Vector3;

use super::seen::{Seen, Shaper};
use super::{Range, between, each_within, within};
use crate::fault::{BuildError, ClampFlags};
use crate::lanes::sqrt;
use crate::stages::output::Output;

/// Largest damping [N s/m], whatever the tangent: a device's own is of the order of 0.1.
/// Source: chosen; with `tau` of 3 ms only a contact above 6 500 N/m reaches it, and no shipped
/// profile has such a ceiling.
pub const MOST_N_S_PER_M: f32 = 20.0;
/// The constant part is faded in up to this force [N], so that the first touch is not felt as a
/// kick.
/// Source: derived; at 0.1 m/s the constant part is 30 mN, which a bare finger just notices (Dosher
/// and Hannaford, Presence 14, 2005): faded in, it is at most a third of the tissue's force
/// (`the_constant_part_is_faded_in_over_the_first_tenth_of_a_newton`).
const FADE_IN_N: f32 = 0.1;
/// For the Hertz slope, depths below this are treated as this depth [m]: there one encoder count
/// would be most of the depth.
/// Source: derived; a count of 55 um is then a fifth of the depth
/// (`the_hertz_slope_ends_at_the_shallowest_depth`).
const SHALLOWEST_M: f32 = 0.3e-3;
/// Backlash applied to the position before its velocity is estimated, in counts (1). It weakens the
/// damping impulse of a flipping count, while a reversing motion is still damped. Without it,
/// tissue of 20 kPa on a frictionless device shakes with 21 mN; with a whole count, a contact of
/// 400 N/m oscillates by two counts (DECISIONS.md).
/// Source: those two runs. At 0.28 `the_velocity_lags_by_no_more_than_a_count_per_tick` fails, at
/// 0.14 `a_count_that_comes_and_goes_is_less_than_a_count_of_motion`.
const PLAY_COUNTS: f32 = 0.2;

/// Gains of the damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DampingSettings {
    /// Damping per tangent stiffness [s].
    pub tau_s: f32,
    /// Constant damping in any contact [N s/m].
    pub constant_n_s_per_m: f32,
    /// One-pole low-pass of the velocity, `1 - exp(-2 pi f T)` (1): share of the newest velocity.
    pub velocity_share: f32,
}

/// Ranges of the settings.
/// Source: chosen; `tau` of the slowest device is 35 ms; the others exclude what is no damping.
static RANGES: [Range; 3] =
    [("damping.tau_s", 0.0, 0.05), ("damping.constant_n_s_per_m", 0.0, MOST_N_S_PER_M), ("damping.velocity_share", 1e-3, 1.0)];

impl DampingSettings {
    /// Share of a 30 Hz low-pass at 1 kHz (1).
    /// Source: `1 - exp(-2 pi f T)`. At 30 Hz the test
    /// `damped_by_the_tangent_400_n_per_m_is_quiet_in_every_hand` passes.
    pub const SHARE_30_HZ: f32 = 0.1718;
    /// No damping: the model's force as it is, for comparison.
    /// Source: definition.
    pub const NONE: Self = Self { tau_s: 0.0, constant_n_s_per_m: 0.0, velocity_share: 1.0 };

    /// Settings that are safe on any tissue, on plain springs and on frictionless devices:
    /// `tau = 2 (delay + T/2)`, 0.3 N s/m (times the ticks of delay if there are several), 30 Hz at
    /// 1 kHz. The delay [s] is the time from computing a force to its acting: whole ticks and the
    /// amplifier's lag.
    ///
    /// Source: twice the negative damping in the header, where once only cancels it. Measured: with
    /// 0.3 N s/m per tick a tap of 1 m/s at two ticks of delay creates 0.0005 mJ, with a total of
    /// 0.3 it creates 0.07 (DECISIONS.md).
    #[must_use]
    #[inline]
    pub fn safe(delay_s: f32, tick_s: f32) -> Self {
        let tau_s = 2.0 * delay_s + tick_s;
        // with more than one tick of delay the motion reverses before the tangent has damped it
        let late = if delay_s > tick_s { delay_s / tick_s } else { 1.0 };
        Self { tau_s, constant_n_s_per_m: 0.3 * late, velocity_share: Self::SHARE_30_HZ }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the first number out of its range.
    #[inline]
    pub fn check(&self) -> Result<(), BuildError> {
        each_within(&RANGES, [self.tau_s, self.constant_n_s_per_m, self.velocity_share])
    }
}

/// Slope of a Hertz contact through this force and depth [N/m]; zero without contact.
#[must_use]
pub fn hertz_slope_n_per_m(output: &Output) -> f32 {
    let depth_m = if output.depth_m > SHALLOWEST_M { output.depth_m } else { SHALLOWEST_M };
    1.5 * output.force_n.dot(&output.normal) / depth_m
}

/// Damps the force of a patch.
#[derive(Clone, Copy, Debug)]
pub struct Damping {
    settings: DampingSettings,
    /// One count of the encoder [m].
    count_m: f32,
    /// Position after a backlash filter [m]: a flipping count moves it by less than a count.
    played_m: Option<Vector3<f32>>,
    velocity_m_per_s: Vector3<f32>,
}

impl Shaper for Damping {
    fn shape(&mut self, force_n: Vector3<f32>, seen: &Seen, _: &mut ClampFlags) -> Vector3<f32> {
        self.damp(&Output { force_n, ..seen.output }, seen.tangent_n_per_m)
    }

    fn reset(&mut self) {
        (self.played_m, self.velocity_m_per_s) = (None, Vector3::zeros());
    }
}

impl Damping {
    /// Creates the damping at rest; `count_m` is one count of the encoder [m].
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the setting.
    #[inline]
    pub fn build(settings: &DampingSettings, tick_s: f32, count_m: f32) -> Result<Self, BuildError> {
        settings.check()?;
        within(&[("tick_s", tick_s, 1e-4, 1e-2), ("device.count_m", count_m, 0.0, 1e-3)])?;
        Ok(Self { settings: *settings, count_m, played_m: None, velocity_m_per_s: Vector3::zeros() })
    }

    /// Takes the position of this tick [m], `1 / per_s` after the last one. Call this in every
    /// tick, also in free space, so that the velocity is right at first touch.
    pub fn track(&mut self, position_m: Vector3<f32>, per_s: f32) {
        let last_m = self.played_m.unwrap_or(position_m);
        let play_m = PLAY_COUNTS * self.count_m;
        let played_m = last_m.zip_map(&position_m, |last, now| between(last, now - play_m, now));
        self.played_m = Some(played_m);
        let newest = (played_m - last_m) * per_s;
        let smooth = self.velocity_m_per_s + (newest - self.velocity_m_per_s) * self.settings.velocity_share;
        // quantisation accounts for one count at most: a larger difference is the lag of the
        // low-pass, and late damping pushes a hand that has reversed
        let fake = self.count_m * per_s;
        let late = smooth - newest;
        self.velocity_m_per_s = if late.dot(&late) > fake * fake {
            smooth.zip_map(&newest, |smooth, newest| between(smooth, newest - fake, newest + fake))
        } else {
            smooth
        };
    }

    /// Low-passed velocity [m/s].
    #[must_use]
    pub fn velocity_m_per_s(&self) -> Vector3<f32> {
        self.velocity_m_per_s
    }

    /// The patch's force with damping [N]; `tangent_n_per_m` is the contact's stiffness along the
    /// normal.
    #[must_use]
    pub fn damp(&self, output: &Output, tangent_n_per_m: f32) -> Vector3<f32> {
        let push_n = output.force_n.dot(&output.normal);
        if push_n <= 0.0 {
            return output.force_n;
        }
        let fade = if push_n < FADE_IN_N { push_n * (1.0 / FADE_IN_N) } else { 1.0 };
        let asked = self.settings.tau_s * tangent_n_per_m + self.settings.constant_n_s_per_m * fade;
        let damping = if asked > MOST_N_S_PER_M { MOST_N_S_PER_M } else { asked };
        let added_n = -damping * self.velocity_m_per_s.dot(&output.normal);
        // the force never pulls: at most the whole push is cancelled
        let added_n = if added_n < -push_n { -push_n } else { added_n };
        let damped_n = output.force_n + output.normal * added_n;
        if output.grip_n > 0.0 { damped_n + self.along(output, push_n, damping) } else { damped_n }
    }

    /// Damping along the surface [N], where friction holds the probe.
    fn along(&self, output: &Output, push_n: f32, damping: f32) -> Vector3<f32> {
        let normal = output.normal;
        let friction_n = output.force_n - normal * push_n;
        let slides_m_per_s = self.velocity_m_per_s - normal * self.velocity_m_per_s.dot(&normal);
        let asked_n = friction_n - slides_m_per_s * damping;
        let (square, given) = (asked_n.dot(&asked_n), friction_n.dot(&friction_n));
        // the model's own force is never cut
        let grip = output.grip_n * output.grip_n;
        let most = if given > grip { given } else { grip };
        let felt_n = if square > most { asked_n * sqrt(most / square) } else { asked_n };
        felt_n - friction_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contact(force_n: Vector3<f32>, normal: Vector3<f32>, depth_m: f32) -> Output {
        Output { force_n, normal, depth_m, ..Output::NONE }
    }

    /// Damping that has tracked this velocity until its estimate settled.
    fn moving(settings: &DampingSettings, velocity_m_per_s: Vector3<f32>) -> Damping {
        let mut damping = Damping::build(settings, 1e-3, 55e-6).unwrap();
        for n in 0..400_u16 {
            damping.track(velocity_m_per_s * (1e-3 * f32::from(n)), 1e3);
        }
        damping
    }

    #[test]
    fn settings_follow_the_delay() {
        for (delay, tau_ms) in [(0.0, 1.0), (1e-3, 3.0), (2e-3, 5.0), (2.5e-3, 6.0)] {
            assert!((DampingSettings::safe(delay, 1e-3).tau_s - tau_ms * 1e-3).abs() < 1e-9);
        }
        let bad = DampingSettings { tau_s: f32::NAN, ..DampingSettings::NONE };
        assert!(Damping::build(&bad, 1e-3, 0.0).is_err());
    }

    #[test]
    fn going_in_adds_tau_k_v_along_the_normal_alone() {
        let normal = Vector3::new(0.6, 0.0, 0.8);
        let velocity = Vector3::new(-0.02, 0.05, -0.01);
        let damping = moving(&DampingSettings::safe(1e-3, 1e-3), velocity);
        let output = contact(normal * 0.8, normal, 2e-3);
        let into = -velocity.dot(&normal);
        let right = normal * (0.8 + (3e-3 * 400.0 + 0.3) * into);
        assert!((damping.damp(&output, 400.0) - right).norm() < 1e-5);
    }

    #[test]
    fn at_rest_and_in_free_space_nothing_is_added_and_it_never_pulls() {
        let rest = moving(&DampingSettings::safe(2e-3, 1e-3), Vector3::zeros());
        let output = contact(Vector3::new(0.3, 0.1, 1.0), Vector3::z(), 1e-3);
        assert_eq!(rest.damp(&output, 1e4), output.force_n);
        for speed in [-0.5, 0.5] {
            let damping = moving(&DampingSettings::safe(1e-3, 1e-3), Vector3::new(0.0, 0.0, speed));
            assert_eq!(damping.damp(&Output::NONE, 400.0), Vector3::zeros());
            assert!(damping.damp(&output, 1e6).z >= 0.0);
            // a model that pulls is not in contact and is not corrected here
            let pulls = contact(Vector3::new(0.0, 0.0, -0.5), Vector3::z(), 1e-3);
            assert_eq!(damping.damp(&pulls, 400.0), pulls.force_n);
        }
        let out = moving(&DampingSettings::safe(1e-3, 1e-3), Vector3::new(0.0, 0.0, 1.0));
        assert_eq!(out.damp(&output, 1e6), Vector3::new(0.3, 0.1, 0.0), "all push gone, nothing more");
    }

    #[test]
    fn a_probe_that_sticks_is_damped_along_the_surface_too_and_one_that_slips_feels_friction_alone() {
        let velocity = Vector3::new(0.02, 0.0, 0.0);
        let damping = moving(&DampingSettings::safe(1e-3, 1e-3), velocity);
        let held = |along_n: f32, grip_n: f32| {
            let output = Output { grip_n, ..contact(Vector3::new(along_n, 0.0, 1.0), Vector3::z(), 2e-3) };
            damping.damp(&output, 400.0)
        };
        let added_n = (3e-3 * 400.0 + 0.3) * 0.02;
        assert!((held(-0.1, 0.5).x - (-0.1 - added_n)).abs() < 1e-6, "it sticks");
        assert!((held(0.1, 0.5).x - (0.1 - added_n)).abs() < 1e-6, "what springs back is damped as well");
        assert!((held(-0.49, 0.5).x + 0.5).abs() < 1e-6, "no more than friction bears");
        assert!((held(-0.5, 0.5).x + 0.5).abs() < 1e-6, "it slips");
        assert_eq!(held(-0.3, 0.0), Vector3::new(-0.3, 0.0, 1.0), "no friction: passed on as it is");
        assert!((held(-0.1, 0.5).z - 1.0).abs() < 1e-6, "nothing along the normal");
        assert!((held(-0.6, 0.5).x + 0.6).abs() < 1e-6, "the model's own force is not cut");
        // while moving in as well, under a larger push, the part along the surface is unchanged
        let sinking = moving(&DampingSettings::safe(1e-3, 1e-3), velocity - Vector3::z() * 0.05);
        let output = Output { grip_n: 0.5, ..contact(Vector3::new(-0.1, 0.0, 2.0), Vector3::z(), 2e-3) };
        let found = sinking.damp(&output, 400.0);
        assert!((found - Vector3::new(-0.1 - added_n, 0.0, 2.0 + 2.5 * added_n)).norm() < 1e-5, "{found}");
    }

    #[test]
    fn the_hertz_slope_is_that_of_a_power_of_three_halves() {
        let force_at = |d: f32| 30.0 * d * crate::lanes::sqrt(d);
        let (d, h) = (4e-3_f32, 1e-5_f32);
        let slope = (force_at(d + h) - force_at(d - h)) / (2.0 * h);
        let output = contact(Vector3::z() * force_at(d), Vector3::z(), d);
        assert!((hertz_slope_n_per_m(&output) / slope - 1.0).abs() < 1e-2);
    }

    #[test]
    fn damping_has_a_largest_value_and_its_constant_part_fades_in() {
        let into = moving(&DampingSettings::safe(1e-3, 1e-3), Vector3::new(0.0, 0.0, -0.1));
        let push = |force_n: f32, tangent| into.damp(&contact(Vector3::z() * force_n, Vector3::z(), 1e-3), tangent).z - force_n;
        assert!((push(1.0, 1e6) - 20.0 * 0.1).abs() < 1e-3, "{}", push(1.0, 1e6));
        assert!((push(1.0, 0.0) - 0.3 * 0.1).abs() < 1e-4, "{}", push(1.0, 0.0));
        assert!((push(0.025, 0.0) - 0.25 * 0.3 * 0.1).abs() < 1e-4, "{}", push(0.025, 0.0));
    }

    #[test]
    fn the_velocity_is_late_by_one_count_per_tick_at_most() {
        let mut turned = moving(&DampingSettings::safe(1e-3, 1e-3), Vector3::new(0.0, 0.0, -1.0));
        let at_m = -0.399;
        for n in 1..=3_u8 {
            turned.track(Vector3::new(0.0, 0.0, at_m + 1e-3 * f32::from(n)), 1e3);
            let late = (turned.velocity_m_per_s().z - 1.0).abs();
            assert!(n < 2 || late <= 0.0551, "tick {n}: late by {late} m/s");
        }
    }

    #[test]
    fn the_hertz_slope_is_bounded_at_the_touch() {
        let slope = |depth_m| hertz_slope_n_per_m(&contact(Vector3::z() * 0.03, Vector3::z(), depth_m));
        assert!((slope(1e-6) - 150.0).abs() < 0.1 && (slope(0.3e-3) - 150.0).abs() < 0.1);
        assert!((slope(0.6e-3) - 75.0).abs() < 0.1);
    }
}
