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

/// Bound on the force error of a scene, from the trial that is most like it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Expected {
    /// Root mean square over places and depths, at most [%].
    pub rms_pct: f64,
    /// Largest magnitude of a force error, at most [%].
    pub worst_pct: f64,
    /// Name of the trial's scene.
    pub trial: String,
    /// Errors of that trial [%]: root mean square, and the largest with its sign.
    pub measured_pct: [f64; 2],
}

impl Expected {
    /// The bound, and the trial that it comes from, in words.
    #[must_use]
    pub fn bound(&self) -> String {
        let [rms_pct, worst_pct] = self.measured_pct;
        format!(
            "at most {:.0} % rms and {:.0} % at worst off finite elements (a bound from trial {}, which was {rms_pct:.1} and {worst_pct:+.0} % off; it holds for each trial from the others)",
            self.rms_pct.ceil(),
            self.worst_pct.ceil(),
            self.trial
        )
    }
}

/// Properties of a press on which the error of a patch depends.
struct Case {
    size_m: [f64; 3],
    poisson_ratio: f64,
    probe: AnswerProbe,
    nodes: usize,
    deepest_m: f64,
    /// Tip that the patch was fitted to, if it was fitted to another.
    fitted: Option<AnswerProbe>,
}

impl Trial {
    fn case(&self) -> Case {
        let Self { block_m, poisson_ratio, probe, nodes, deepest_m, fitted, .. } = self;
        Case {
            size_m: *block_m,
            poisson_ratio: *poisson_ratio,
            probe: *probe,
            nodes: *nodes,
            deepest_m: *deepest_m,
            fitted: *fitted,
        }
    }

    /// Distance of a case from the trial (1).
    fn unlike(&self, case: &Case) -> f64 {
        let [x, y, z] = self.block_m;
        let radius_m = case.probe.radius_m;
        let ratio = |own: f64, other: f64, scale: f64| ((own / other).ln() / scale).powi(2);
        let squares = ((case.poisson_ratio - self.poisson_ratio) / POISSON_RATIO).powi(2)
            + ratio(case.nodes as f64, self.nodes as f64, NODES)
            + ratio(radius_m / case.size_m[2], self.probe.radius_m / z, RADIUS)
            + ratio(radius_m / case.size_m[0].min(case.size_m[1]), self.probe.radius_m / x.min(y), RADIUS)
            + ratio(case.deepest_m / radius_m, self.deepest_m / self.probe.radius_m, DEPTH)
            + unlike_shape(&case.probe, &self.probe).powi(2);
        // how much larger the tip is than the fitted one, in the case and in the trial
        let unlike_fit = match (&case.fitted, &self.fitted) {
            (Some(own), Some(theirs)) => {
                let scale = (radius_m / own.radius_m) / (self.probe.radius_m / theirs.radius_m);
                (scale.ln() / RADIUS).abs() + unlike_shape(own, theirs)
            }
            _ => 0.0,
        };
        squares.sqrt() + unlike_fit
    }
}

/// The trial that is most like a case, and its distance (1).
fn nearest<'a>(case: &Case, trials: impl Iterator<Item = &'a Trial>) -> Option<(f64, &'a Trial)> {
    trials.map(|trial| (trial.unlike(case), trial)).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Growth of an error per unit of distance, and at least for one unit (1): the largest logarithm of
/// the ratio between a trial and the one most like it. With it, each trial that is left out is
/// bounded by the others.
fn growth(trials: &[Trial], error: impl Fn(&Trial) -> f64) -> f64 {
    let from_others = |(n, own): (usize, &Trial)| {
        let others = trials.iter().enumerate().filter(|(other, _)| *other != n).map(|(_, trial)| trial);
        nearest(&own.case(), others).map_or(0.0, |(unlike, other)| (error(own) / error(other)).ln() / unlike.max(1.0))
    };
    trials.iter().enumerate().map(from_others).fold(0.0, f64::max)
}

/// The trials that are shipped.
#[must_use]
pub fn shipped() -> Vec<Trial> {
    serde_json::from_str(TRIALS).unwrap_or_default()
}

/// Bound on the error of a scene on a block with `nodes` nodes: uncalibrated, or with a patch
/// fitted to another tip on the same tissue. It is the error of the nearest trial, grown with the
/// distance from it. `None` if there is no trial of that kind; no trial
/// has tissue that stiffens or a tilted tip.
#[must_use]
pub fn expected(scene: &Scene, nodes: usize, fitted: Option<&FitRecord>) -> Option<Expected> {
    if scene.probe.is_tilted() {
        return None;
    }
    let (tissue, radius_m) = (&scene.tissue, scene.probe.radius_m);
    let deepest_m = match &scene.drive {
        Drive::Depth { holds_m, .. } | Drive::Hand { holds_m, .. } => holds_m.iter().copied().fold(0.0, f64::max),
        Drive::Force { .. } | Drive::Trace { .. } => 0.5 * radius_m,
    };
    let case = Case {
        size_m: tissue.block_m.filter(|_| tissue.most_stiffening_b() == 0.0)?,
        poisson_ratio: tissue.poisson_ratio,
        probe: scene.probe.tip(),
        nodes,
        deepest_m,
        fitted: fitted.map(|record| record.probe),
    };
    let is_same = |record: &FitRecord| {
        record.probe != case.probe && record.tissue.poisson_ratio == case.poisson_ratio && record.tissue.block_m == tissue.block_m
    };
    if !fitted.is_none_or(is_same) {
        return None;
    }
    let mut trials = shipped();
    trials.retain(|trial| trial.fitted.is_some() == fitted.is_some());
    let (unlike, nearest) = nearest(&case, trials.iter())?;
    let bound = |error: fn(&Trial) -> f64| error(nearest) * (unlike.max(1.0) * growth(&trials, error)).exp();
    Some(Expected {
        rms_pct: bound(|trial| trial.rms_pct),
        worst_pct: bound(|trial| trial.worst_pct.abs()),
        trial: nearest.scene.clone(),
        measured_pct: [nearest.rms_pct, nearest.worst_pct],
    })
}

/// Distance between two tips apart from their size (1): flat or not, and the ratio of width to
/// radius.
fn unlike_shape(one: &AnswerProbe, other: &AnswerProbe) -> f64 {
    let flat = |tip: &AnswerProbe| tip.shape == Shape::Flat;
    let wide = |tip: &AnswerProbe| (tip.half_widths_m().iter().product::<f64>() / tip.radius_m.powi(2)).ln();
    let shape = if flat(one) == flat(other) { 0.0 } else { OTHER_SHAPE };
    shape + 0.5 * (wide(one) - wide(other)).abs() / RADIUS
}
