//! What a hand does: the motion of its target.

use std::f64::consts::TAU;

use palpate::Vector3;

use crate::closed_loop::stimulus::{CLEAR_M, Site};

/// Kind of a motion. A person does every one of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MotionKind {
    /// Presses, holds, and lets go slowly.
    Hold,
    /// Kneads: the depth swings.
    Knead,
    /// Presses and moves in circles.
    Circle,
    /// Taps again and again.
    Taps,
    /// Presses and slides.
    Slide,
    /// Presses and stops dead.
    DeadStop,
    /// Presses, holds and drifts along the surface.
    Drift,
}

impl MotionKind {
    /// Every kind.
    pub const ALL: [Self; 7] = [Self::Hold, Self::Knead, Self::Circle, Self::Taps, Self::Slide, Self::DeadStop, Self::Drift];

    /// Name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Hold => "hold",
            Self::Knead => "knead",
            Self::Circle => "circle",
            Self::Taps => "taps",
            Self::Slide => "slide",
            Self::DeadStop => "dead stop",
            Self::Drift => "drift",
        }
    }

    /// Whether the force should be steady but for the hand's own slow motion.
    #[must_use]
    pub fn is_slow(self) -> bool {
        self != Self::Taps
    }
}

/// A motion with its numbers.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Kind of the motion.
    pub kind: MotionKind,
    /// Depth of the target at which the tip rests at `depth_m` [m].
    pub reach_m: f64,
    /// Depth of the tip [m].
    pub depth_m: f64,
    /// Duration of a press [s].
    pub press_s: f64,
    /// Share of the depth that swings (1).
    pub share: f64,
    /// Frequency of kneading, circling and tapping [Hz].
    pub hz: f64,
    /// Tremor of the hand: amplitude [m] and frequency [Hz].
    pub tremor_m: f64,
    /// Frequency of the tremor [Hz].
    pub tremor_hz: f64,
    /// Speed along the surface [m/s].
    pub aside_m_per_s: f64,
    /// Place along the surface [m].
    pub place_m: [f64; 2],
    /// Phase of the tremor (1).
    pub phase: f64,
}

impl Motion {
    /// Position of the hand's target after `t_s` of a run of `seconds` [m].
    #[must_use]
    pub fn target_m(&self, site: &Site, t_s: f64, seconds: f64) -> Vector3<f64> {
        let [x, y] = self.place_m;
        let smooth = |share: f64| {
            let s = share.clamp(0.0, 1.0);
            s * s * (3.0 - 2.0 * s)
        };
        let linear = |share: f64| share.clamp(0.0, 1.0);
        let (press_s, leave_s) = (self.press_s, seconds - 0.6);
        let out = smooth((t_s - leave_s) / 0.4);
        let held_s = (t_s - press_s).max(0.0);
        let swing = 0.5 - 0.5 * (TAU * self.hz * held_s).cos();
        let (mut dip, mut aside, mut across) = (smooth(t_s / press_s), 0.0, 0.0);
        match self.kind {
            MotionKind::Hold => {}
            MotionKind::Knead => dip -= self.share * swing * dip,
            MotionKind::Circle => {
                let radius_m = (self.aside_m_per_s / (TAU * self.hz)).min(4e-3);
                (aside, across) = (radius_m * (TAU * self.hz * held_s).sin(), radius_m * (1.0 - (TAU * self.hz * held_s).cos()));
            }
            MotionKind::Taps => dip = (TAU * self.hz * t_s).sin().max(-0.5) * 1.0,
            MotionKind::Slide => {
                // there and back over 8 mm
                let way_m = self.aside_m_per_s * held_s / 8e-3;
                let fold = (way_m.rem_euclid(2.0) - 1.0).abs();
                aside = 8e-3 * (0.5 - fold);
                aside += 4e-3;
            }
            MotionKind::DeadStop => dip = linear(t_s / press_s),
            MotionKind::Drift => aside = (1e-3 * held_s).min(4e-3),
        }
        let tremor_m = self.tremor_m * (TAU * (self.tremor_hz * t_s + self.phase)).sin();
        let depth_m = (self.reach_m + CLEAR_M) * dip - CLEAR_M;
        let depth_m = depth_m + (-CLEAR_M - depth_m) * out;
        site.point_m(depth_m + tremor_m, x + aside, y + across + 0.5 * tremor_m)
    }
}
