//! An elastic layer that ties two surfaces together, whether or not their meshes match.
//!
//! For the seven quadrature points of each triangle on the first surface, the nearest points at
//! rest on the second are determined. From then on the energy of each pair per rest area is
//! `k/2 |x_a - x_b - (X_a - X_b)|^2`: a penalty tie at quadrature points with one leading surface
//! (Wriggers, *Computational Contact Mechanics*, 6). The offset at rest is stored as a vector, so
//! the energy is quadratic in the displacements, and a common rotation costs energy if the surfaces
//! do not touch at rest. A uniform pressure is transmitted uniformly only within the error of the
//! quadrature, because the points of one surface do not match the sides of the other's triangles.

use nalgebra::Vector3;

use palpate_fit::reference::assembly::Pattern;
use palpate_fit::reference::body::Assembled;
use palpate_fit::reference::nearest::nearest;
use palpate_fit::reference::quadratic::QuadraticMesh;
use palpate_fit::reference::shape::{triangle_points, triangle_shape};

/// A spring between a point on one surface and a point on another.
#[derive(Clone, Debug, PartialEq)]
pub struct Tie {
    /// Nodes of the triangle on the first surface, then those of the triangle on the second.
    pub nodes: [u32; 12],
    /// Shape functions at the two points. Those of the second triangle are negative, so that the
    /// weighted sum of the nodes' displacements is the stretch.
    pub shape: [f64; 12],
    /// Stiffness over Young's modulus [m]: that of the layer per area [1/m], times the rest area
    /// that the point represents.
    pub stiffness_m: f64,
    /// Distance between the two points at rest [m].
    pub gap_m: f64,
}

impl Tie {
    /// Displacement of the first point relative to the second [m].
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

/// Ties some triangles of a mesh to the nearest of others that are within `reach_m` at rest; `from`
/// and `onto` are indices of its surface triangles.
///
/// `stiffness_per_m` gives the stiffness of the layer per area, over Young's modulus [1/m], at a
/// place [m] on the first surface; points at which it is not above zero are not tied. The two
/// surfaces should have no common nodes.
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
