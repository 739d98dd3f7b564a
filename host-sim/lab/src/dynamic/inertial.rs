//! Consistent masses, and the potential whose minimum is the end of one implicit step.

use nalgebra::Vector3;

use super::scheme::Anchored;
use palpate_fit::reference::body::{Assembled, Body, Contact};
use palpate_fit::reference::minimise::Potential;
use palpate_fit::reference::shape::{TetRule, tet_shape, tet_slopes};

/// Integrals of the products of shape functions [m^3], in the order of the body's tangent.
pub(super) fn masses_m3(body: &Body) -> Vec<f64> {
    // the products have degree 4, which this rule integrates exactly
    let rule = TetRule::Eleven.points();
    let mut share = [[0.0; 10]; 10];
    for (at, weight) in rule {
        let shape = tet_shape(at);
        for (a, row) in share.iter_mut().enumerate() {
            for (b, value) in row.iter_mut().enumerate() {
                *value += weight * shape[a] * shape[b];
            }
        }
    }
    let mut values = vec![0.0; body.pattern.entries()];
    for tet in &body.mesh.tets {
        let (_, volume_m3) = tet_slopes([0, 1, 2, 3].map(|k| body.mesh.nodes_m[tet[k] as usize]));
        for a in 0..10 {
            for b in 0..=a {
                body.pattern.add_scalar(&mut values, tet[a], tet[b], volume_m3 * share[a][b]);
            }
        }
    }
    values
}

/// Elastic and inertial energy of a step, over Young's modulus [m^3].
pub(super) struct Inertial<'a> {
    pub body: &'a Body,
    pub contact: Option<&'a Contact>,
    pub masses_m3: &'a [f64],
    /// Density over Young's modulus [s^2/m^2].
    pub density_s2_per_m2: f64,
    pub anchored: &'a Anchored,
    /// Lower limit of the force over Young's modulus with which the residual is compared [m^2].
    pub least_force_m2: f64,
}

impl Inertial<'_> {
    fn weight(&self) -> f64 {
        self.density_s2_per_m2 * self.anchored.weight_per_s2
    }

    /// Vector from the centre of each node's spring to the node [m], and the product of the mass
    /// matrix with it.
    fn pull(&self, displacement_m: &[Vector3<f64>]) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
        let away: Vec<_> = displacement_m.iter().zip(&self.anchored.centre_m).map(|(u, centre)| u - centre).collect();
        let pull = self.body.pattern.multiply(self.masses_m3, &away);
        (away, pull)
    }

    fn energy_m3(&self, away: &[Vector3<f64>], pull: &[Vector3<f64>]) -> f64 {
        0.5 * self.weight() * away.iter().zip(pull).map(|(a, p)| a.dot(p)).sum::<f64>()
    }
}

impl Potential for Inertial<'_> {
    fn body(&self) -> &Body {
        self.body
    }

    fn contact(&self) -> Option<&Contact> {
        self.contact
    }

    fn energy(&self, displacement_m: &[Vector3<f64>]) -> Option<f64> {
        let (away, pull) = self.pull(displacement_m);
        Some(self.body.energy(displacement_m, None)? + self.energy_m3(&away, &pull))
    }

    fn assemble(&self, displacement_m: &[Vector3<f64>], tangent: bool) -> Option<Assembled> {
        let mut sum = self.body.derive(displacement_m, tangent)?;
        let (away, pull) = self.pull(displacement_m);
        let weight = self.weight();
        sum.energy_m3 += self.energy_m3(&away, &pull);
        for (residual, pull) in sum.residual_m2.iter_mut().zip(&pull) {
            *residual += pull * weight;
        }
        for (value, mass) in sum.tangent.iter_mut().zip(self.masses_m3) {
            *value += weight * mass;
        }
        Some(sum)
    }

    fn force_m2(&self, displacement_m: &[Vector3<f64>], _: &Assembled) -> f64 {
        let contact = self.contact.map_or(0.0, |contact| self.body.touch(displacement_m, contact).force_m2.norm());
        (contact / self.body.copies).max(self.least_force_m2)
    }
}
