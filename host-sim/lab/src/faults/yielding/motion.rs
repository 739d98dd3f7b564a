//! Motion of a hand: that of its target.

use std::f64::consts::TAU;

use palpate::Vector3;

use palpate_loop::closed_loop::stimulus::{CLEAR_M, Site};

/// Largest radius of circles [m], and the stretch over which a slide goes to and fro [m].
const WIDEST_M: f64 = 4e-3;
const SLIDE_M: f64 = 8e-3;
/// Speed [m/s] and extent [m] of a drift.
const DRIFT_M_PER_S: f64 = 1e-3;
const DRIFT_M: f64 = 4e-3;
/// Height of the hand between taps, as a share of its reach (1).
const BETWEEN_TAPS: f64 = 0.5;
/// Time before the end of a motion at which the hand leaves, and the time that leaving takes [s].
const LEAVES_S: f64 = 0.6;
const LEAVING_S: f64 = 0.4;

/// Kind of a motion. A person does every one of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionKind {
    /// Presses, holds, and leaves slowly.
    Hold,
    /// Kneads: the depth swings.
    Knead,
    /// Presses and moves in circles.
    Circle,
    /// Taps again and again.
    Taps,
    /// Presses and slides to and fro.
    Slide,
    /// Presses at a steady speed and stops dead.
    DeadStop,
    /// Presses, holds and drifts along the surface.
    Drift,
}

impl MotionKind {
    /// Every kind.
    pub const ALL: [Self; 7] = [Self::Hold, Self::Knead, Self::Circle, Self::Taps, Self::Slide, Self::DeadStop, Self::Drift];

    /// Name in tables.
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

    /// Whether the force changes only as slowly as the hand moves, so that any force above 15 Hz is
    /// the loop's.
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
    /// Share of the depth that swings when kneading (1).
    pub share: f64,
    /// Frequency of kneading, circling and tapping [Hz].
    pub hz: f64,
    /// Amplitude of the hand's tremor [m].
    pub tremor_m: f64,
    /// Frequency of the tremor [Hz].
    pub tremor_hz: f64,
    /// Speed of circles and slides along the surface [m/s].
    pub aside_m_per_s: f64,
    /// Place along the surface [m].
    pub place_m: [f64; 2],
    /// Phase of tremor and shaking (1).
    pub phase: f64,
    /// Acceleration with which the hand shakes on purpose [m/s^2]: zero for what people do.
    pub shake_m_per_s2: f64,
    /// Frequency of that shaking [Hz].
    pub shake_hz: f64,
}

impl Motion {
    /// Position of the hand's target after `t_s` of a motion of `seconds` [m].
    pub fn target_m(&self, site: &Site, t_s: f64, seconds: f64) -> Vector3<f64> {
        let held_s = (t_s - self.press_s).max(0.0);
        let turn = TAU * self.hz * held_s;
        let pressed = smooth(t_s / self.press_s);
        let (mut dip, mut along_m, mut across_m) = (pressed, 0.0, 0.0);
        match self.kind {
            MotionKind::Hold => {}
            MotionKind::Knead => dip -= self.share * (0.5 - 0.5 * turn.cos()) * pressed,
            MotionKind::Circle => {
                let radius_m = (self.aside_m_per_s / (TAU * self.hz)).min(WIDEST_M);
                (along_m, across_m) = (radius_m * turn.sin(), radius_m * (1.0 - turn.cos()));
            }
            MotionKind::Taps => dip = (TAU * self.hz * t_s).sin().max(-BETWEEN_TAPS),
            MotionKind::Slide => {
                let passes = self.aside_m_per_s * held_s / SLIDE_M;
                along_m = SLIDE_M * (1.0 - ((passes + 1.0).rem_euclid(2.0) - 1.0).abs());
            }
            MotionKind::DeadStop => dip = (t_s / self.press_s).clamp(0.0, 1.0),
            MotionKind::Drift => along_m = (DRIFT_M_PER_S * held_s).min(DRIFT_M),
        }
        let depth_m = (self.reach_m + CLEAR_M) * dip - CLEAR_M;
        let left = smooth((t_s - (seconds - LEAVES_S)) / LEAVING_S);
        let depth_m = depth_m - (CLEAR_M + depth_m) * left;
        let tremor_m = self.tremor_m * (TAU * (self.tremor_hz * t_s + self.phase)).sin();
        let shake_rad_per_s = TAU * self.shake_hz;
        let shake_m =
            self.shake_m_per_s2 / (shake_rad_per_s * shake_rad_per_s) * (shake_rad_per_s * t_s + TAU * self.phase).sin();
        let [x, y] = self.place_m;
        site.point_m(depth_m + tremor_m + shake_m, x + along_m, y + across_m + 0.5 * tremor_m)
    }
}

/// A share of a motion that starts and ends at rest.
fn smooth(share: f64) -> f64 {
    let s = share.clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}
