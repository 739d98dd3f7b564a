//! An elastic layer that ties two surfaces together, with matching meshes or not.
//!
//! At the seven points of each triangle of the one surface, the other's nearest point at rest is
//! sought; from then on `k/2 |x_a - x_b - (X_a - X_b)|^2` per rest area: a penalty tie on
//! quadrature points, one surface leading (Wriggers, *Computational Contact Mechanics*, 6). The
//! offset at rest is kept as a vector, so the energy is quadratic in the displacements and a common
//! rotation costs energy if the surfaces do not touch at rest. A uniform pressure is transmitted
//! uniformly only within the quadrature's error: one surface's points do not match the sides of the
//! other's triangles.

use nalgebra::Vector3;

use super::assembly::Pattern;
use super::body::Assembled;
use super::nearest::nearest;
use super::quadratic::QuadraticMesh;
use super::shape::{triangle_points, triangle_shape};

/// A spring between a point of one surface and one of another.
#[derive(Clone, Debug, PartialEq)]
pub struct Tie {
    /// Nodes of the triangle on the one surface, then of that on the other.
    pub nodes: [u32; 12],
    /// Shape functions at the two points. Those of the second triangle are negative, so that the
    /// sum over the nodes' displacements is the stretch.
    pub shape: [f64; 12],
    /// Stiffness over Young's modulus [m]: of the layer per area [1/m], times the point's area at
    /// rest.
    pub stiffness_m: f64,
    /// Distance of the two points at rest [m].
    pub gap_m: f64,
}

impl Tie {
    /// Relative displacement of the points [m].
    #[must_use]
    pub fn stretch_m(&self, displacement_m: &[Vector3<f64>]) -> Vector3<f64> {
        self.nodes.iter().zip(&self.shape).map(|(n, share)| displacement_m[*n as usize] * *share).sum()
    }

    pub(super) fn energy_m3(&self, displacement_m: &[Vector3<f64>]) -> f64 {
        0.5 * self.stiffness_m * self.stretch_m(displacement_m).norm_squared()
    }

    pub(super) fn add(&self, displacement_m: &[Vector3<f64>], pattern: &Pattern, sum: &mut Assembled) {
        let stretch_m = self.stretch_m(displacement_m);
        sum.energy_m3 += 0.5 * self.stiffness_m * stretch_m.norm_squared();
        for (a, i) in self.nodes.iter().enumerate() {
            sum.residual_m2[*i as usize] += stretch_m * (self.stiffness_m * self.shape[a]);
            for (b, j) in self.nodes.iter().enumerate().filter(|(_, j)| *j <= i) {
                pattern.add_scalar(&mut sum.tangent, *i, *j, self.stiffness_m * self.shape[a] * self.shape[b]);
            }
        }
    }
}

/// Ties some triangles of a mesh to the nearest of others (both indices into its surface triangles)
/// that are within `reach_m` at rest.
///
/// `stiffness_per_m` gives the layer's stiffness per area over Young's modulus [1/m] at a place [m]
/// of the first surface; nothing is tied where it is not above zero. The two surfaces should have
/// no node in common.
#[must_use]
pub fn layer(
    mesh: &QuadraticMesh,
    from: &[usize],
    onto: &[usize],
    reach_m: f64,
    stiffness_per_m: impl Fn(&Vector3<f64>) -> f64,
) -> Vec<Tie> {
    let mut ties = Vec::new();
    for t in from {
        let own = &mesh.triangles[*t];
        let corners = [0, 1, 2].map(|k| mesh.nodes_m[own[k] as usize]);
        let area_m2 = 0.5 * (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm();
        for (at, share) in triangle_points() {
            let place = corners[0] * at[0] + corners[1] * at[1] + corners[2] * at[2];
            let stiffness_m = stiffness_per_m(&place) * share * area_m2;
            if !(stiffness_m > 0.0 && stiffness_m.is_finite()) {
                continue;
            }
            let Some(other) = nearest(mesh, onto.iter().copied(), &place, reach_m) else { continue };
            let (near, far) = (triangle_shape(at), triangle_shape(other.at));
            let (mut nodes, mut shape) = ([0; 12], [0.0; 12]);
            for k in 0..6 {
                (nodes[k], shape[k]) = (own[k], near[k]);
                (nodes[6 + k], shape[6 + k]) = (mesh.triangles[other.triangle][k], -far[k]);
            }
            ties.push(Tie { nodes, shape, stiffness_m, gap_m: other.distance_m });
        }
    }
    ties
}
