//! Moving-least-squares shape functions of scattered nodes with a linear basis (Lancaster and
//! Salkauskas 1981; in Galerkin's method Belytschko, Lu and Gu 1994).
//!
//! `phi_n(x) = w(|X_n - x| / R_n) p_n^T A^-1 p(x)`, `A = sum_n w_n p_n p_n^T`, `p_n = (1, X_n -
//! x)`, so `p(x) = (1, 0, 0, 0)`. They reproduce linear fields whatever the weights. The weight is
//! that of Most and Bucher 2005, `(r^2 + e)^-2 - (1 + e)^-2`, which is so steep at its node that
//! the field passes through the nodal values; with the usual splines it does not. Reaches follow
//! the mesh: each node acts at every integration point of its own tets. At the points of a face all
//! corners of the adjacent tets act; these are not coplanar, so A can be inverted.

use nalgebra::{Matrix4, Vector4};
use palpate::Vector3;

use palpate_tissue::error::Error;
use palpate_tissue::mesh::TetMesh;

/// Regularisation e of the weight's pole (1): the field misses a nodal value by a relative error of
/// about e^2.
const SOFTENING: f64 = 1e-5;

/// Corners of the faces of a tet, counter-clockwise as seen from outside.
pub(super) const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// A node and the value of its shape function (1).
pub type Share = (u32, f64);

/// Rest positions of the nodes, and the reach of their weights.
#[derive(Clone, Debug)]
pub struct ShapeFunctions {
    node_m: Vec<Vector3<f64>>,
    reach_m: Vec<f64>,
}

impl ShapeFunctions {
    /// Creates the shape functions of a mesh's nodes. A node reaches `reach` times as far as the
    /// farthest integration point of its tets; `reach` must be above 1.
    pub fn new(mesh: &TetMesh, reach: f64) -> Self {
        let node_m: Vec<_> = mesh.nodes_m.iter().map(|x| Vector3::from(*x)).collect();
        let mut reach_m = vec![0.0_f64; node_m.len()];
        for tet in &mesh.tets {
            let corners_m = tet.map(|n| node_m[n as usize]);
            let points_m = FACES.map(|face| integration_points_m(&face.map(|k| corners_m[k])));
            for (&n, corner_m) in tet.iter().zip(&corners_m) {
                let farthest_m = points_m.iter().flatten().map(|x| (x - corner_m).norm()).fold(0.0, f64::max);
                reach_m[n as usize] = reach_m[n as usize].max(reach * farthest_m);
            }
        }
        Self { node_m, reach_m }
    }

    /// Shape functions that are not zero at a point of the rest configuration [m], in ascending
    /// order of nodes.
    pub fn at(&self, at_m: &Vector3<f64>) -> Result<Vec<Share>, Error> {
        let mut near = Vec::new();
        let mut moment = Matrix4::zeros();
        for (n, (x, reach_m)) in (0_u32..).zip(self.node_m.iter().zip(&self.reach_m)) {
            let away_m = x - at_m;
            let square = away_m.norm_squared() / (reach_m * reach_m);
            if square < 1.0 {
                let basis = Vector4::new(1.0, away_m.x, away_m.y, away_m.z);
                let weight = weight(square);
                moment += basis * basis.transpose() * weight;
                near.push((n, weight, basis));
            }
        }
        let Some(factor) = moment.cholesky() else {
            let [x, y, z] = [at_m.x, at_m.y, at_m.z].map(|c| c * 1e3);
            let count = near.len();
            return Err(Error::Usage(format!(
                "meshless: the {count} nodes that reach ({x:.1}, {y:.1}, {z:.1}) mm span no volume: remove flat tets or let nodes reach farther"
            )));
        };
        let coefficients = factor.solve(&Vector4::x());
        Ok(near.into_iter().map(|(n, weight, basis)| (n, weight * coefficients.dot(&basis))).collect())
    }

    /// Means of the shape functions over a triangle of the rest configuration, in ascending order
    /// of nodes.
    pub fn mean(&self, corners_m: &[Vector3<f64>; 3]) -> Result<Vec<Share>, Error> {
        let mut parts = Vec::new();
        for at_m in integration_points_m(corners_m) {
            parts.extend(self.at(&at_m)?.into_iter().map(|(n, phi)| (n, phi / 3.0)));
        }
        Ok(summed(parts))
    }
}

/// Points half way from the centre of a triangle to its corners, which with equal weights integrate
/// quadratic polynomials exactly.
pub fn integration_points_m(corners_m: &[Vector3<f64>; 3]) -> [Vector3<f64>; 3] {
    let middle_m = (corners_m[0] + corners_m[1] + corners_m[2]) / 3.0;
    corners_m.map(|corner_m| middle_m.lerp(&corner_m, 0.5))
}

/// Sums the values of each node; returns the sums in ascending order of nodes.
pub(super) fn summed<T: Copy + std::ops::Add<Output = T>>(mut parts: Vec<(u32, T)>) -> Vec<(u32, T)> {
    parts.sort_by_key(|(n, _)| *n);
    let of_one = |run: &[(u32, T)]| (run[0].0, run[1..].iter().fold(run[0].1, |sum, (_, part)| sum + *part));
    parts.chunk_by(|a, b| a.0 == b.0).map(of_one).collect()
}

/// Weight at a squared distance, relative to the squared reach.
fn weight(square: f64) -> f64 {
    let pole = |s: f64| (s + SOFTENING).powi(-2);
    pole(square) - pole(1.0)
}
