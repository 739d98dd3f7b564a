//! Draws the progress of a calibration over its rounds: force error and dent error.

use std::path::Path;

use super::ChartError;
use super::figure::Figure;
use super::plot::{Plot, ScaledAxis, Series};

/// State of a calibration after a round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConvergencePoint {
    /// Number of evaluations of all presses so far.
    pub evaluations: usize,
    /// Rms force error over the fitted places [%].
    pub force_rms_pct: f64,
    /// Mean dent error over the fitted places [mm].
    pub dent_mean_mm: f64,
    /// Time since the fit began [s].
    pub elapsed_s: f64,
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
pub fn convergence(folder: &Path, name: &str, scene: &str, rounds: &[ConvergencePoint]) -> Result<(), ChartError> {
    let curve = |name: &str, of: fn(&ConvergencePoint) -> f64| {
        Series::curve(name, rounds.iter().map(|r| (r.evaluations as f64, of(r)))).marked()
    };
    let series = vec![curve("force, rms [%]", |r| r.force_rms_pct), curve("dent, mean [mm]", |r| r.dent_mean_mm)];
    let plot = Plot::new(ScaledAxis::linear("evaluations of all presses"), ScaledAxis::linear("error [% or mm]"), series);
    let below = format!("over the fitted places; {:.0} s in all", rounds.last().map_or(0.0, |r| r.elapsed_s));
    Figure::plot(name, format!("{scene}: calibration, errors against evaluations"), below, plot).draw(folder)
}
