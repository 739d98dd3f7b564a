//! Finds the displacement of any point of an organ, given by its position at rest.

use nalgebra::Vector3;

use super::organs::Organ;
use palpate_fit::reference::nearest::nearest;
use palpate_fit::reference::quadratic::QuadraticMesh;
use palpate_fit::reference::shape::{tet_shape, tet_slopes, triangle_shape};

/// Amount by which rounding may place volume coordinates outside a tet (1).
const SLACK: f64 = 1e-9;

/// Finds points of one organ by their position at rest.
pub struct Locator<'a> {
    mesh: &'a QuadraticMesh,
    organ: Organ,
    reach_m: f64,
    tets: Vec<Place>,
}

/// A tet, prepared for testing whether it contains a point.
struct Place {
    least_m: Vector3<f64>,
    most_m: Vector3<f64>,
    corner_m: Vector3<f64>,
    slopes_per_m: [Vector3<f64>; 4],
}

impl<'a> Locator<'a> {
    /// Prepares an organ of a mesh. A point outside the organ is replaced by the nearest point on
    /// its surface, if that is within `reach_m`.
    pub fn new(mesh: &'a QuadraticMesh, organ: &Organ, reach_m: f64) -> Self {
        let tets = mesh.tets[organ.tets.clone()].iter().map(|tet| {
            let corners = [0, 1, 2, 3].map(|k| mesh.nodes_m[tet[k] as usize]);
            let (slopes_per_m, _) = tet_slopes(corners);
            let bound = |pick: fn(f64, f64) -> f64| corners[1..].iter().fold(corners[0], |b, x| b.zip_map(x, pick));
            Place { least_m: bound(f64::min), most_m: bound(f64::max), corner_m: corners[0], slopes_per_m }
        });
        Self { mesh, organ: organ.clone(), reach_m, tets: tets.collect() }
    }

    /// Nodes and shape functions of a point at rest [m]; `None` if the point is too far outside.
    pub fn weights(&self, point_m: &Vector3<f64>) -> Option<Vec<(u32, f64)>> {
        for (place, nodes) in self.tets.iter().zip(&self.mesh.tets[self.organ.tets.clone()]) {
            if let Some(at) = place.holds(point_m) {
                return Some(nodes.iter().copied().zip(tet_shape(at)).collect());
            }
        }
        let found = nearest(self.mesh, self.organ.triangles.clone(), point_m, self.reach_m)?;
        Some(self.mesh.triangles[found.triangle].iter().copied().zip(triangle_shape(found.at)).collect())
    }

    /// Displacement [m] of a point at rest [m], interpolated from those of the nodes; `None` if the
    /// point is too far outside.
    pub fn displacement_at(&self, displacement_m: &[Vector3<f64>], point_m: &Vector3<f64>) -> Option<Vector3<f64>> {
        Some(self.weights(point_m)?.into_iter().map(|(n, share)| displacement_m[n as usize] * share).sum())
    }
}

impl Place {
    /// Volume coordinates of a point; `None` if it is outside the tet.
    fn holds(&self, point_m: &Vector3<f64>) -> Option<[f64; 4]> {
        let slack_m = (self.most_m - self.least_m).max() * SLACK;
        if (0..3).any(|k| point_m[k] < self.least_m[k] - slack_m || point_m[k] > self.most_m[k] + slack_m) {
            return None;
        }
        let arm = point_m - self.corner_m;
        let rest = [1, 2, 3].map(|k: usize| self.slopes_per_m[k].dot(&arm));
        let at = [1.0 - rest.iter().sum::<f64>(), rest[0], rest[1], rest[2]];
        at.iter().all(|part| *part >= -SLACK).then_some(at)
    }
}
