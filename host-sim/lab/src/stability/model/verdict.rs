//! Verdict on a press: the worst thing that went wrong, if any.

use palpate::ClampFlags;
use palpate_tissue::shard::exact;
use serde::{Deserialize, Serialize};

use super::press::{Loading, Trace};

/// Volume ratio below which a tet counts as inside out (1).
const LEAST_J: f64 = 0.05;
/// Least force of a hold, as a share of the largest (1).
const LEAST_HELD: f64 = 0.01;
/// Largest displacement of a node [m] and relative change of the force (1) in the last 20 ms of the
/// hold, as in `chart`.
const STILL_M: f64 = 5e-5;
const STILL_FORCE: f64 = 0.05;
/// Largest displacement that may be left after the release [m].
const RETURNED_M: f64 = 5e-5;
/// Largest fall of the force during the descent, as a share of its largest (1).
const MOST_DROP: f64 = 0.02;

/// From good to bad.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Nothing went wrong.
    Pass,
    /// Nothing went wrong, at a depth where the guard held the tip.
    Held,
    /// The force fell while the tip went deeper.
    NonMonotone,
    /// The tissue is not back at rest half a second after the release.
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
    /// In the order of keys and counts.
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
    #[must_use]
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

/// Numbers of a press.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// The verdict.
    pub verdict: Verdict,
    /// Smallest J in any tick (1).
    #[serde(with = "exact")]
    pub lowest_j: f64,
    /// Smallest J at the end of the hold (1).
    #[serde(with = "exact")]
    pub held_j: f64,
    /// Largest displacement left [mm].
    #[serde(with = "exact")]
    pub residual_mm: f64,
    /// Fall of the force during the descent, as a share of its largest [%].
    #[serde(with = "exact")]
    pub drop_pct: f64,
    /// Largest displacement of a node at the end of the hold [mm].
    #[serde(with = "exact")]
    pub moved_mm: f64,
    /// Change of the force in that time [%].
    #[serde(with = "exact")]
    pub force_change_pct: f64,
    /// Force at the end of the hold [N].
    #[serde(with = "exact")]
    pub held_n: f64,
    /// Largest force [N].
    #[serde(with = "exact")]
    pub peak_n: f64,
    /// Depth at divergence [mm].
    pub diverged_at_mm: Option<f64>,
    /// Inputs that the guard clamped.
    #[serde(with = "exact::clamp_flags")]
    pub limiters: ClampFlags,
}

/// Classifies a press. If it is `slow`, the force during the descent is the tissue's and must not
/// fall.
#[must_use]
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
        limiters: trace.limiters,
    }
}

/// Largest fall of the force below its value at a smaller depth, over the largest force (1).
fn largest_drop(loading: &[Loading]) -> f64 {
    let (mut highest_n, mut drop_n) = (0.0_f64, 0.0_f64);
    for tick in loading {
        highest_n = highest_n.max(tick.force_n);
        drop_n = drop_n.max(highest_n - tick.force_n);
    }
    if highest_n > 0.0 { drop_n / highest_n } else { 0.0 }
}
