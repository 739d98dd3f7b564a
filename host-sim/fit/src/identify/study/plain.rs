//! Tissue without stiffening, beside one that stiffens.

use super::super::fit::{Fitted, Problem, Settings};
use super::super::model::Tissue;

/// The best tissues without stiffening, each with its rms error over the peak [%].
pub(super) struct Plain {
    best: (Tissue, f64),
    /// With the surface where stiffening tissue has it.
    held: (Tissue, f64),
    /// Information gained by the exponent.
    pub gain: f64,
}

impl Plain {
    /// Compares a fit with those of the same rows without stiffening; `None` if nothing fits.
    pub fn of(problem: &Problem, fit: &Fitted) -> Option<Self> {
        let delay = fit.delay_s() != 0.0;
        let mut plain = problem.with(problem.records(), Settings { stiffens: false, delay, ..Settings::default() });
        let first = plain.solve()?;
        // to seem as soft at first, such tissue would begin below its surface
        let mut at_surface = problem.records().to_vec();
        at_surface.iter_mut().enumerate().for_each(|(n, record)| record.contact_m = fit.contact_m(n));
        let settings = Settings { stiffens: false, contact: false, delay, ..Settings::default() };
        let mut held = problem.with(&at_surface, settings);
        let held = held.solve().map(|fit| (fit.tissue(), held.rms_pct(&fit)))?;
        // all models are compared with the same noise and the same number of independent points
        let independent = problem.points() as f64 / fit.inflation;
        let criterion = |rms_pct: f64, terms: usize| 2.0 * independent * rms_pct.ln() + 4.0 * terms as f64;
        let of = |(tissue, rms_pct): &(Tissue, f64)| criterion(*rms_pct, tissue.terms.len());
        let free = [Some(first), plain.without_stiffening(fit)].into_iter().flatten();
        let all = free.map(|fit| (fit.tissue(), plain.rms_pct(&fit))).chain([held.clone()]);
        let best = all.min_by(|a, b| of(a).total_cmp(&of(b)))?;
        let gain = of(&best) - criterion(problem.rms_pct(fit), fit.terms()) - 2.0;
        Some(Self { best, held, gain })
    }

    /// The one to tell, beside tissue that stiffens or does not.
    pub fn told(self, stiffens: bool) -> (Tissue, f64) {
        if stiffens { self.held } else { self.best }
    }
}
