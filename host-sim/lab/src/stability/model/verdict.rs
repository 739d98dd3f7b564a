//! Verdict on a press: its worst failure, if any.

use crate::study::number;
use palpate::ClampFlags;
use serde::{Deserialize, Serialize};

use super::press::{Loading, Trace};

/// Volume ratio below which a tet counts as inverted (1).
const LEAST_J: f64 = 0.05;
/// Smallest force of a hold, as a share of the largest force (1).
const LEAST_HELD: f64 = 0.01;
/// Largest accepted displacement of a node [m] and relative change of the force (1) in the last 20
/// ms of the hold, as in `chart`.
const STILL_M: f64 = 5e-5;
const STILL_FORCE: f64 = 0.05;
/// Largest accepted distance of a node from its rest position after the release [m].
const RETURNED_M: f64 = 5e-5;
/// Largest accepted fall of the force during the descent, as a share of the largest force (1).
const MOST_DROP: f64 = 0.02;

/// Verdicts in ascending order of severity.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The press has no failure.
    Pass,
    /// The press has no failure, and the guard held the tip at the depth limit.
    Held,
    /// The force fell while the tip went deeper.
    NonMonotone,
    /// The tissue has not returned to its rest shape half a second after the release.
    Deformed,
    /// The tissue still moves at the end of the hold.
    Restless,
    /// No force is left at the end of the hold: the probe went through the surface.
    Pierced,
    /// A tet lost 95 % of its volume or turned inside out.
    Inverted,
    /// The computation diverged.
    Diverged,
}

impl Verdict {
    /// All verdicts in the order of keys and counts.
    pub const ALL: [Self; 8] = [
        Self::Pass,
        Self::Held,
        Self::NonMonotone,
        Self::Deformed,
        Self::Restless,
        Self::Pierced,
        Self::Inverted,
        Self::Diverged,
    ];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Held => "held",
            Self::NonMonotone => "non-monotone",
            Self::Deformed => "deformed",
            Self::Restless => "restless",
            Self::Pierced => "pierced",
            Self::Inverted => "inverted",
            Self::Diverged => "diverged",
        }
    }
}

/// Figures of a press.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Worst failure of the press, if any.
    pub verdict: Verdict,
    /// Smallest volume ratio J of a tet in any tick (1).
    #[serde(with = "number")]
    pub lowest_j: f64,
    /// Smallest volume ratio J of a tet at the end of the hold (1).
    #[serde(with = "number")]
    pub held_j: f64,
    /// Largest distance of a node from its rest position after the release [mm].
    #[serde(with = "number")]
    pub residual_mm: f64,
    /// Fall of the force during the descent, relative to the largest force [%].
    #[serde(with = "number")]
    pub drop_pct: f64,
    /// Largest displacement of a node in the last 20 ms of the hold [mm].
    #[serde(with = "number")]
    pub moved_mm: f64,
    /// Change of the force in the last 20 ms of the hold [%].
    #[serde(with = "number")]
    pub force_change_pct: f64,
    /// Force at the end of the hold [N].
    #[serde(with = "number")]
    pub held_n: f64,
    /// Largest force [N].
    #[serde(with = "number")]
    pub peak_n: f64,
    /// Depth at divergence [mm].
    pub diverged_at_mm: Option<f64>,
    /// Whether the guard clamped the depth.
    pub depth_held: bool,
    /// Whether the guard clamped the speed.
    pub speed_limited: bool,
    /// Whether the force was clamped.
    pub force_cut: bool,
}

/// Classifies a press. If the press is `slow`, the force during the descent is due to the stiffness
/// of the tissue and must not fall.
pub fn judge(trace: &Trace, slow: bool) -> Figures {
    let drop = largest_drop(&trace.loading);
    let at_most = |value: f64, most: f64| value <= most;
    let verdict = if trace.diverged_at_m.is_some() {
        Verdict::Diverged
    } else if !at_most(LEAST_J, trace.lowest_j) {
        Verdict::Inverted
    } else if !at_most(LEAST_HELD * trace.peak_n, trace.held_n) {
        Verdict::Pierced
    } else if !at_most(trace.moved_m, STILL_M) || !at_most(trace.force_change, STILL_FORCE) {
        Verdict::Restless
    } else if !at_most(trace.residual_m, RETURNED_M) {
        Verdict::Deformed
    } else if slow && !at_most(drop, MOST_DROP) {
        Verdict::NonMonotone
    } else if trace.limiters.contains(ClampFlags::DEPTH) {
        Verdict::Held
    } else {
        Verdict::Pass
    };
    Figures {
        verdict,
        lowest_j: trace.lowest_j,
        held_j: trace.held_j,
        residual_mm: trace.residual_m * 1e3,
        drop_pct: drop * 100.0,
        moved_mm: trace.moved_m * 1e3,
        force_change_pct: trace.force_change * 100.0,
        held_n: trace.held_n,
        peak_n: trace.peak_n,
        diverged_at_mm: trace.diverged_at_m.map(|d| d * 1e3),
        depth_held: trace.limiters.contains(ClampFlags::DEPTH),
        speed_limited: trace.limiters.contains(ClampFlags::SPEED),
        force_cut: trace.limiters.contains(ClampFlags::FORCE),
    }
}

/// Largest fall of the force below its value at a smaller depth, divided by the largest force (1).
fn largest_drop(loading: &[Loading]) -> f64 {
    let (mut highest_n, mut drop_n) = (0.0_f64, 0.0_f64);
    for tick in loading {
        highest_n = highest_n.max(tick.force_n);
        drop_n = drop_n.max(highest_n - tick.force_n);
    }
    if highest_n > 0.0 { drop_n / highest_n } else { 0.0 }
}
