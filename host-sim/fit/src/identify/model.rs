//! Force of a test in time: the elastic curve under linear relaxation.
//!
//! While the contact grows, the force is the hereditary integral over the elastic force. On the way
//! back the contact shrinks element by element: the curve is a row of Maxwell chains whose onsets
//! are spread over the depth by its second derivative (the method of dimensionality reduction, see
//! [`crate::half_space`]), and each chain loses contact where it would pull.

use super::elastic::{Curve, Elastic};
use super::record::Record;
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

/// Forces in the first rows of a record, with what they are made of: a change of one constant
/// leaves most of it as it was.
#[derive(Clone, Debug, Default)]
pub struct Forces {
    /// Exponent (1), first contact [m] and delay [s] of the elastic forces.
    elastic_of: [f64; 3],
    /// Elastic force over E [m^2].
    elastic_m2: Vec<f64>,
    /// Time of each term [s] and its decays.
    decays: Vec<(f64, Vec<Decay>)>,
    tissue: Option<Tissue>,
    force_n: Vec<f64>,
}

/// Share of a term's force that is left after the way from one row to the next, and the share of a
/// step of the elastic force that the term bears at its end.
type Decay = [f64; 2];

fn decays(term_s: f64, rows_s: &[f64]) -> Vec<Decay> {
    let of = |way_s: f64| {
        let x = way_s / term_s;
        let left = (-x).exp();
        [left, if x > 1e-6 { (1.0 - left) / x } else { 1.0 }]
    };
    std::iter::once(0.0).chain(rows_s.windows(2).map(|w| w[1] - w[0])).map(of).collect()
}

impl Forces {
    /// Forces [N] while the depth does not fall, of a tissue whose surface lies at a depth [m], if
    /// they come so late [s]. The rows and the elastic curves must be the same in every call.
    pub fn growing_n(
        &mut self,
        elastic: &Elastic,
        tissue: &Tissue,
        (record, rows): (&Record, usize),
        surface_m: f64,
        delay_s: f64,
    ) -> &[f64] {
        let elastic_of = [tissue.stiffening_b, surface_m, delay_s];
        if self.tissue.as_ref() == Some(tissue) && self.elastic_of == elastic_of {
            return &self.force_n;
        }
        if self.tissue.is_none() || self.elastic_of != elastic_of {
            let (curve, depth_m) = (elastic.at(tissue.stiffening_b), record.delayed_m(delay_s, surface_m));
            self.elastic_m2 = depth_m[..rows].iter().map(|depth_m| curve.force_m2(*depth_m)).collect();
            self.elastic_of = elastic_of;
        }
        self.decays.resize(tissue.terms.len(), (f64::NAN, Vec::new()));
        for ((_, term_s), (of_s, of)) in tissue.terms.iter().zip(&mut self.decays).filter(|(term, of)| term.1 != of.0) {
            (*of_s, *of) = (*term_s, decays(*term_s, &record.time_s[..rows]));
        }
        self.tissue = Some(tissue.clone());
        let modulus_pa = tissue.youngs_modulus_pa;
        let kept: f64 = 1.0 - tissue.terms.iter().map(|(share, _)| share).sum::<f64>();
        self.force_n.clear();
        self.force_n.extend(self.elastic_m2.iter().map(|elastic| modulus_pa * kept * elastic));
        for ((share, _), (_, decays)) in tissue.terms.iter().zip(&self.decays) {
            let (mut borne, mut last) = (0.0, 0.0);
            for ((force, elastic), [left, rise]) in self.force_n.iter_mut().zip(&self.elastic_m2).zip(decays) {
                borne = left * borne + rise * (elastic - last);
                last = *elastic;
                *force += modulus_pa * share * borne;
            }
        }
        &self.force_n
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
