//! Deviation of a patch from its targets.

use super::Round;

/// Errors of one evaluation, in plain units.
#[derive(Clone, Debug, Default)]
pub struct Measurement {
    /// Force divided by its target, minus one (1): one list per place, in the order of increasing
    /// depth.
    pub forces: Vec<Vec<f64>>,
    /// Distances between the surface nodes and the reference [m], one list per dent.
    pub dents_m: Vec<Vec<f64>>,
    /// Force of each glued disc divided by its target, minus one (1).
    pub glued: Vec<f64>,
    /// Sum of the squared errors in units of their tolerance (1).
    pub misfit: f64,
}

impl Measurement {
    /// Root mean square of all force errors [%].
    #[must_use]
    pub fn force_rms_pct(&self) -> f64 {
        let all: Vec<f64> = self.forces.iter().flatten().copied().collect();
        100.0 * (all.iter().map(|e| e * e).sum::<f64>() / all.len().max(1) as f64).sqrt()
    }

    /// Mean distance between the surface nodes and the reference [mm], averaged over the dents.
    #[must_use]
    pub fn dent_mean_mm(&self) -> f64 {
        let mean = |d: &Vec<f64>| d.iter().sum::<f64>() / d.len().max(1) as f64;
        1e3 * self.dents_m.iter().map(mean).sum::<f64>() / self.dents_m.len().max(1) as f64
    }

    pub(super) fn round(&self, evaluations: usize, ridge: f64, elapsed_s: f64) -> Round {
        Round {
            evaluations,
            cost: self.misfit + ridge,
            force_rms_pct: self.force_rms_pct(),
            dent_mean_mm: self.dent_mean_mm(),
            elapsed_s,
        }
    }
}
