//! The law of a patch in uniform deformation: the stress of a block that is compressed between
//! frictionless platens, computed from the energies of springs and volume as the core documents
//! them.

use palpate::stages::force::compensation::BARRIER_BELOW;
use palpate::stages::force::stiffening::CAP;
use palpate::stages::force::volume::STRAIGHT_BELOW;
use palpate::{Model, Params};

/// The springs of a patch, each with the squared cosine of its angle to the axis of compression,
/// and the volumes of its nodes.
pub struct Uniform {
    springs: Vec<([usize; 2], f64, f64, f64)>,
    volume_m3: Vec<f64>,
    kappa: Vec<f64>,
    bulk_m3: f64,
    barrier_m3: f64,
    mu: f64,
    onset: f64,
    compensation: f64,
}

/// Number of bisections in the search for the lateral stretch.
const HALVINGS: usize = 60;

impl Uniform {
    /// Converts a patch, which is then compressed along z.
    pub fn of(model: &Model, params: &Params) -> Self {
        let rest = |n: usize| nalgebra::Vector3::from(model.nodes[n].rest_m.map(f64::from));
        let springs = model.springs.iter().map(|s| {
            let node = [s.i, s.j].map(usize::from);
            let d = rest(node[1]) - rest(node[0]);
            let (k, rest_m) = (f64::from(s.k), f64::from(s.k_rest) / f64::from(s.k));
            (node, k, rest_m, (d.z / d.norm()).powi(2))
        });
        let of_tets = |law: fn(&palpate::Tet) -> f32| -> f64 {
            model.tets.iter().map(|t| f64::from(law(t)) / f64::from(t.six_volume_reciprocal)).sum()
        };
        Self {
            springs: springs.collect(),
            volume_m3: model.nodes.iter().map(|n| f64::from(n.volume_m3)).collect(),
            kappa: model.nodes.iter().map(|n| 12.0 * f64::from(n.pressure)).collect(),
            bulk_m3: of_tets(|t| t.bulk),
            barrier_m3: of_tets(|t| t.barrier),
            mu: 0.5 / (1.0 + f64::from(params.poisson_ratio)),
            onset: 1.0 - f64::from(params.compensation_threshold),
            compensation: f64::from(params.compensation),
        }
    }

    /// Derivatives of the energy, divided by E [m^3], with respect to the stretch of the height and
    /// to that of the width.
    fn slopes(&self, b: f64, along: f64, across: f64) -> [f64; 2] {
        let mut energy = vec![0.0; self.volume_m3.len()];
        let mut tension = Vec::with_capacity(self.springs.len());
        for (node, k, rest_m, square) in &self.springs {
            let ratio = (along * along * square + across * across * (1.0 - square)).sqrt();
            let squeezed = (ratio - self.onset).min(0.0) * rest_m;
            let stretched = (ratio - 1.0) * rest_m;
            let half = 0.25 * k * (stretched * stretched + self.compensation * squeezed * squeezed);
            node.iter().for_each(|&n| energy[n] += half);
            tension.push(k * (stretched + self.compensation * squeezed) * rest_m / ratio);
        }
        let ln = energy.iter().zip(&self.volume_m3).map(|(energy, volume)| 2.0 * b * energy / volume / self.mu);
        let factor: Vec<f64> = ln.map(|ln| ln.min(f64::from(CAP)).exp()).collect();
        let mut slopes = [0.0; 2];
        for ((node, _, _, square), tension) in self.springs.iter().zip(tension) {
            let pull = 0.5 * (factor[node[0]] + factor[node[1]]) * tension;
            slopes[0] += pull * along * square;
            slopes[1] += pull * across * (1.0 - square);
        }
        let j = along * across * across;
        let straight = f64::from(STRAIGHT_BELOW);
        let law = |j: f64| (j - 1.0) / (j * (j + 1.0));
        let steep = |j: f64| (1.0 + 2.0 * j - j * j) / (j * (j + 1.0)).powi(2);
        let nodal = if j < straight { law(straight) + steep(straight) * (j - straight) } else { law(j) };
        let nodal: f64 = self.kappa.iter().zip(&self.volume_m3).map(|(kappa, v)| kappa * v * 2.0 * nodal).sum();
        let lack = (1.0 - j / f64::from(BARRIER_BELOW)).max(0.0);
        let pressure = nodal + self.bulk_m3 * (j - 1.0) - self.barrier_m3 * lack;
        slopes[0] += pressure * across * across;
        slopes[1] += pressure * 2.0 * along * across;
        slopes
    }

    /// Engineering stress divided by E (1) at an engineering strain, both positive in compression.
    pub fn stress(&self, b: f64, strain: f64) -> f64 {
        let along = 1.0 - strain;
        let (mut low, mut high) = (0.9, 2.5);
        for _ in 0..HALVINGS {
            let across = 0.5 * (low + high);
            if self.slopes(b, along, across)[1] > 0.0 { high = across } else { low = across }
        }
        -self.slopes(b, along, 0.5 * (low + high))[0] / self.volume_m3.iter().sum::<f64>()
    }
}
