//! Force errors of patches in trials, from which the error of a scene without a fit is estimated.
//!
//! Each row of the table is a patch that was pressed as in its scene and compared with finite
//! elements: uncalibrated, or calibrated for another tip. `palpate fit` writes the rows of its
//! scene (`trials.json`); those of the scenes in `host-sim/scenes/trials` are shipped.

use serde::{Deserialize, Serialize};

use crate::answer::AnswerProbe;
use crate::fit_record::FitRecord;
use crate::scene::{Drive, Scene, Shape};

/// The trials that are shipped.
const TRIALS: &str = include_str!("../../references/trials.json");
/// Difference of Poisson's ratio that counts as a distance of one between scenes (1).
const POISSON_RATIO: f64 = 0.06;
/// Difference of the logarithm of the number of nodes that counts as one (1).
const NODES: f64 = 1.2;
/// Difference of the logarithm of radius over thickness, or radius over side, that counts as one
/// (1).
const RADIUS: f64 = 0.7;
/// Difference of the logarithm of depth over radius that counts as one (1).
const DEPTH: f64 = 1.0;
/// Distance of a scene from a trial below which they count as alike (1).
const ALIKE: f64 = 1.0;
/// Distance between a flat and a round tip (1).
const OTHER_SHAPE: f64 = 3.0;

/// One trial, a row of the table.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Name of the trial's scene.
    pub scene: String,
    /// Sides of the block [m].
    pub block_m: [f64; 3],
    /// Poisson's ratio (1).
    pub poisson_ratio: f64,
    /// Tip that pressed the patch.
    pub probe: AnswerProbe,
    /// Number of nodes of the patch.
    pub nodes: usize,
    /// Depth of the deepest press [m].
    pub deepest_m: f64,
    /// Tip that the patch was fitted to; `None` if it was not fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fitted: Option<AnswerProbe>,
    /// Force error over places and depths, root mean square [%].
    pub rms_pct: f64,
    /// Largest force error, with its sign [%].
    pub worst_pct: f64,
}

/// Expected force error of a scene, taken from the trial that is most like it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Expected {
    /// Root mean square over places and depths [%].
    pub rms_pct: f64,
    /// Largest force error, with its sign [%].
    pub worst_pct: f64,
    /// Name of the trial's scene.
    pub trial: String,
    /// Whether the trial is alike enough for its error to be expected.
    pub alike: bool,
}

impl Trial {
    /// Distance of a scene from the trial (1); below one they are alike.
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

/// The trials that are shipped.
#[must_use]
pub fn shipped() -> Vec<Trial> {
    serde_json::from_str(TRIALS).unwrap_or_default()
}

/// Expected error of a scene on a block with `nodes` nodes: uncalibrated, or with a patch fitted to
/// another tip on the same tissue. `None` if there is no trial of that kind; no trial has tissue
/// that stiffens.
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
    // compares how much larger the tip is than the fitted one in the scene and in the trial
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

/// Distance between two tips apart from their size (1): flat or not, and the ratio of width to
/// radius.
fn unlike_shape(one: &AnswerProbe, other: &AnswerProbe) -> f64 {
    let flat = |tip: &AnswerProbe| tip.shape == Shape::Flat;
    let wide = |tip: &AnswerProbe| (tip.half_widths_m().iter().product::<f64>() / tip.radius_m.powi(2)).ln();
    let shape = if flat(one) == flat(other) { 0.0 } else { OTHER_SHAPE };
    shape + 0.5 * (wide(one) - wide(other)).abs() / RADIUS
}
