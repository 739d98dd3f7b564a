//! Stiffening, as in the tick (`core/src/stages/force/stiffening.rs`): the factor by which the
//! tissue at each node is stiffer than at rest, and the contribution of its change to the tangent.

use nalgebra::Matrix3;
use palpate::Params;
use palpate::stages::force::stiffening::CAP;

use super::contact::Push;
use super::{Statics, Vector};

/// Share of a foundation point's energy that is assigned to its nodes, because its other end is the
/// probe (1).
const HALF: f64 = 0.5;

/// Ratio of the logarithm of a stiffness factor to the energy density divided by E (1); zero if the
/// tissue does not stiffen.
pub(super) fn steepness(params: &Params) -> f64 {
    let mu = 0.5 / (1.0 + f64::from(params.poisson_ratio));
    if params.terms.stiffening { 2.0 * f64::from(params.stiffening_b) / mu } else { 0.0 }
}

/// Stiffness factors of a deformed patch.
pub(super) struct Stiffer {
    /// Stiffness factor of every node (1).
    factor: Vec<f64>,
    /// Derivative of every factor with respect to the energy at its node, divided by E [1/m^3];
    /// zero at the cap.
    steeper: Vec<f64>,
}

impl Stiffer {
    /// Stiffness factor of a spring: the mean of those of its ends (1).
    pub fn of_spring(&self, [a, b]: [usize; 2]) -> f64 {
        0.5 * (self.factor[a] + self.factor[b])
    }

    /// Stiffness factor of a foundation point, from those of its nodes (1).
    pub fn of_point(&self, node: [usize; 3], weights: [f64; 3]) -> f64 {
        let mean: f64 = node.iter().zip(weights).map(|(&n, w)| w * self.factor[n]).sum();
        1.0 + HALF * (mean - 1.0)
    }
}

impl Statics {
    /// The stiffness factors at `x`; `None` if the tissue does not stiffen.
    pub(super) fn stiffer(&self, x: &[Vector], pushes: &[Push]) -> Option<Stiffer> {
        if self.steepness == 0.0 {
            return None;
        }
        let mut energy = vec![0.0; x.len()];
        for s in &self.springs {
            let half = 0.5 * self.pull(s, x).energy();
            s.node.iter().for_each(|&n| energy[n] += half);
        }
        for push in pushes {
            let node = self.triangles[push.triangle].node;
            node.iter().zip(push.weights).for_each(|(&n, w)| energy[n] += w * HALF * push.energy);
        }
        let of_node = |((n, energy), reciprocal): ((usize, &f64), &f64)| {
            // the volume of a node is a quarter of that of its tets
            let per_energy = self.steepness * self.steepness_of.get(n).unwrap_or(&1.0) * 24.0 * reciprocal;
            let ln = energy * per_energy;
            let factor = ln.min(f64::from(CAP)).exp();
            (factor, if ln < f64::from(CAP) { factor * per_energy } else { 0.0 })
        };
        let (factor, steeper) = energy.iter().enumerate().zip(&self.six_volume_reciprocal).map(of_node).unzip();
        Some(Stiffer { factor, steeper })
    }

    /// Adds the contribution of the change of the factors to the tangent; `stars` lists the nodes
    /// around each node.
    pub(super) fn add_steeper(
        &self,
        stiffer: &Stiffer,
        stars: &[Vec<usize>],
        x: &[Vector],
        pushes: &[Push],
        add: &mut impl FnMut(usize, usize, &Matrix3<f64>),
    ) {
        // gradients of the energy at each node with respect to the nodes around it
        let mut slopes: Vec<Vec<Vector>> = stars.iter().map(|s| vec![Vector::zeros(); s.len()]).collect();
        let mut put = |at: usize, along: usize, slope: Vector| {
            if let Ok(place) = stars[at].binary_search(&along) {
                slopes[at][place] += slope;
            }
        };
        for s in &self.springs {
            let pull = self.pull(s, x);
            let half = pull.along * (0.5 * pull.tension);
            for at in s.node {
                put(at, s.node[1], half);
                put(at, s.node[0], -half);
            }
        }
        for push in pushes {
            let node = self.triangles[push.triangle].node;
            for (&at, share) in node.iter().zip(push.weights) {
                for (&along, weight) in node.iter().zip(push.weights) {
                    put(at, along, push.out * (-push.force * HALF * share * weight));
                }
            }
        }
        for ((star, slopes), steeper) in stars.iter().zip(&slopes).zip(&stiffer.steeper) {
            for (&a, along_a) in star.iter().zip(slopes) {
                for (&b, along_b) in star.iter().zip(slopes) {
                    if self.free[a] >= self.free[b] {
                        add(a, b, &(along_a * along_b.transpose() * *steeper));
                    }
                }
            }
        }
    }
}
