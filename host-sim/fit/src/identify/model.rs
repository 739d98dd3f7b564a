//! Force of a test in time: the elastic curve under linear relaxation.
//!
//! While the contact grows, the force is the hereditary integral over the elastic force. On the way
//! back the contact shrinks element by element: the curve is a row of Maxwell chains whose onsets
//! are spread over the depth by its second derivative (the method of dimensionality reduction, see
//! [`crate::half_space`]), and each chain loses contact where it would pull.

use super::elastic::Curve;
use crate::half_space::Chain;

/// Number of chains of a row.
const CHAINS: usize = 80;

/// Constants of a tissue under test.
#[derive(Clone, Debug, PartialEq)]
pub struct Tissue {
    /// Instantaneous Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
    /// Stiffening exponent (1).
    pub stiffening_b: f64,
    /// Share (1) and time [s] of each Prony term, the fastest first.
    pub terms: Vec<(f64, f64)>,
}

/// Forces [N] at times [s] and depths below the surface [m], while the depth does not fall.
pub fn growing_n(tissue: &Tissue, curve: &Curve, time_s: &[f64], depth_m: &[f64], out: &mut Vec<f64>) {
    out.clear();
    let mut borne = [0.0; 3];
    let (mut last_s, mut last) = (time_s.first().copied().unwrap_or(0.0), 0.0);
    let kept: f64 = 1.0 - tissue.terms.iter().map(|(share, _)| share).sum::<f64>();
    for (t, depth_m) in time_s.iter().zip(depth_m) {
        let elastic = curve.force_m2(*depth_m);
        let dt = t - last_s;
        let mut force = kept * elastic;
        for ((share, time_s), borne) in tissue.terms.iter().zip(&mut borne) {
            let x = dt / time_s;
            let left = (-x).exp();
            let rise = if x > 1e-6 { (1.0 - left) / x } else { 1.0 };
            *borne = left * *borne + rise * (elastic - last);
            force += share * *borne;
        }
        out.push(tissue.youngs_modulus_pa * force);
        (last_s, last) = (*t, elastic);
    }
}

/// Forces [N] at times [s] and depths below the surface [m] of any motion.
#[must_use]
pub fn any_n(tissue: &Tissue, curve: &Curve, time_s: &[f64], depth_m: &[f64]) -> Vec<f64> {
    let deepest_m = depth_m.iter().copied().fold(0.0, f64::max);
    let step_m = deepest_m / CHAINS as f64;
    let at = |n: f64| curve.force_m2(n * step_m);
    let mut row: Vec<(f64, f64, Chain)> = (0..CHAINS)
        .map(|n| {
            let n = n as f64;
            let weight = (at(n + 1.0) - 2.0 * at(n) + at((n - 1.0).max(0.0))).max(0.0) / step_m;
            (n * step_m, weight, Chain::new(tissue.terms.len()))
        })
        .collect();
    let mut last_s = time_s.first().copied().unwrap_or(0.0);
    let mut forces = Vec::with_capacity(time_s.len());
    for (t, depth_m) in time_s.iter().zip(depth_m) {
        let dt = (t - last_s).max(1e-9);
        last_s = *t;
        let push = |(onset_m, weight, chain): &mut (f64, f64, Chain)| *weight * chain.step(&tissue.terms, depth_m - *onset_m, dt);
        forces.push(tissue.youngs_modulus_pa * row.iter_mut().map(push).sum::<f64>());
    }
    forces
}
