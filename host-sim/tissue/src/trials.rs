//! Errors of patches in trials: a table of fits, for an estimate if nothing was fitted.
//!
//! Every row is a patch pressed as in its scene and compared with finite elements: uncalibrated, or
//! calibrated for another tip. `palpate fit` writes the rows of its scene (`trials.json`); those of
//! the scenes in `host-sim/scenes/trials` ship.

use serde::{Deserialize, Serialize};

use crate::answer::AnswerProbe;
use crate::fit_record::FitRecord;
use crate::scene::{Drive, Scene, Shape};

/// The trials that ship.
const TRIALS: &str = include_str!("../../references/trials.json");
/// Differences that weigh equally between scenes: of the Poisson's ratio (1), of the logarithms of
/// node count, of radius over thickness and over side, and of depth over radius.
const POISSON_RATIO: f64 = 0.06;
const NODES: f64 = 1.2;
const RADIUS: f64 = 0.7;
const DEPTH: f64 = 1.0;
/// Distance below which trials count as alike.
const ALIKE: f64 = 1.0;
/// Distance between a disc and a ball.
const OTHER_SHAPE: f64 = 3.0;

/// One trial, a row of the table.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Scene of the trial.
    pub scene: String,
    /// Sides of the block [m].
    pub block_m: [f64; 3],
    /// Poisson's ratio (1).
    pub poisson_ratio: f64,
    /// Tip that pressed.
    pub probe: AnswerProbe,
    /// Nodes of the patch.
    pub nodes: usize,
    /// Deepest press [m].
    pub deepest_m: f64,
    /// Tip that the patch was fitted to; none if it was not fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fitted: Option<AnswerProbe>,
    /// Force error over places and depths, root mean square [%].
    pub rms_pct: f64,
    /// The largest, with its sign [%].
    pub worst_pct: f64,
}

/// Error to expect, from the nearest trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Expected {
    /// Root mean square over places and depths [%].
    pub rms_pct: f64,
    /// The largest, with its sign [%].
    pub worst_pct: f64,
    /// The trial's scene.
    pub trial: String,
    /// Whether the trial is like the scene.
    pub alike: bool,
}

impl Trial {
    /// Distance of a scene from the trial; below one they are alike.
    fn unlike(&self, scene: &Scene, size_m: [f64; 3], nodes: usize) -> f64 {
        let deepest_m = match &scene.drive {
            Drive::Depth { holds_m, .. } | Drive::Hand { holds_m, .. } => holds_m.iter().copied().fold(0.0, f64::max),
            Drive::Force { .. } | Drive::Trace { .. } => 0.5 * scene.probe.radius_m,
        };
        let radius_m = scene.probe.radius_m;
        let own = scene.probe.tip();
        let [x, y, z] = self.block_m;
        let ratio = |own: f64, other: f64, scale: f64| ((own / other).ln() / scale).powi(2);
        let squares = ((scene.tissue.poisson_ratio - self.poisson_ratio) / POISSON_RATIO).powi(2)
            + ratio(nodes as f64, self.nodes as f64, NODES)
            + ratio(radius_m / size_m[2], self.probe.radius_m / z, RADIUS)
            + ratio(radius_m / size_m[0].min(size_m[1]), self.probe.radius_m / x.min(y), RADIUS)
            + ratio(deepest_m / radius_m, self.deepest_m / self.probe.radius_m, DEPTH)
            + unlike_shape(&own, &self.probe).powi(2);
        squares.sqrt()
    }
}

/// The trials that ship.
#[must_use]
pub fn shipped() -> Vec<Trial> {
    serde_json::from_str(TRIALS).unwrap_or_default()
}

/// Error to expect of a scene on a block with `nodes` nodes: uncalibrated, or with a patch fitted
/// to another tip on the same tissue. `None` if there is no trial of that kind: no trial stiffens.
#[must_use]
pub fn expected(scene: &Scene, nodes: usize, fitted: Option<&FitRecord>) -> Option<Expected> {
    let size_m = scene.tissue.block_m.filter(|_| scene.tissue.most_stiffening_b() == 0.0)?;
    let own = scene.probe.tip();
    let of_kind = |trial: &Trial| match fitted {
        None => trial.fitted.is_none(),
        Some(record) => {
            record.probe != own
                && record.tissue.poisson_ratio == scene.tissue.poisson_ratio
                && record.tissue.block_m == scene.tissue.block_m
                && trial.fitted.is_some()
        }
    };
    // a tip larger than the fitted one by this factor
    let unlike_fit = |trial: &Trial| match (fitted, &trial.fitted) {
        (Some(record), Some(theirs)) => {
            let scale = (own.radius_m / record.probe.radius_m) / (trial.probe.radius_m / theirs.radius_m);
            (scale.ln() / RADIUS).abs() + unlike_shape(&record.probe, theirs)
        }
        _ => 0.0,
    };
    let trials = shipped();
    let ranked = trials.iter().filter(|trial| of_kind(trial)).map(|t| (t.unlike(scene, size_m, nodes) + unlike_fit(t), t));
    let (unlike, nearest) = ranked.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Expected { rms_pct: nearest.rms_pct, worst_pct: nearest.worst_pct, trial: nearest.scene.clone(), alike: unlike < ALIKE })
}

/// Difference of two tips apart from their size: flat or not, and the ratio of width to depth.
fn unlike_shape(one: &AnswerProbe, other: &AnswerProbe) -> f64 {
    let flat = |tip: &AnswerProbe| tip.shape == Shape::Flat;
    let wide = |tip: &AnswerProbe| (tip.half_widths_m().iter().product::<f64>() / tip.radius_m.powi(2)).ln();
    let shape = if flat(one) == flat(other) { 0.0 } else { OTHER_SHAPE };
    shape + 0.5 * (wide(one) - wide(other)).abs() / RADIUS
}
