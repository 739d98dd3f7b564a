//! Finds the point of a surface that is nearest to a given point, at rest, where all triangles are
//! flat.

use nalgebra::Vector3;

use super::quadratic::QuadraticMesh;
use palpate_tissue::mesh::triangle::nearest_on_triangle;

/// A point of a surface triangle.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Index of the triangle in the mesh.
    pub triangle: usize,
    /// Area coordinates of the point in the triangle (1).
    pub at: [f64; 3],
    /// Distance between the two points [m].
    pub distance_m: f64,
}

/// Nearest point of the given triangles within `reach_m`; `None` if there is none.
#[must_use]
pub fn nearest(
    mesh: &QuadraticMesh,
    triangles: impl IntoIterator<Item = usize>,
    point_m: &Vector3<f64>,
    reach_m: f64,
) -> Option<Nearest> {
    let mut best: Option<Nearest> = None;
    for triangle in triangles {
        let nodes = &mesh.triangles[triangle];
        let corners = [0, 1, 2].map(|k| mesh.nodes_m[nodes[k] as usize]);
        let within_m = best.map_or(reach_m, |b| b.distance_m);
        let outside = |k: usize| {
            let [a, b, c] = corners.map(|x| x[k]);
            point_m[k] < a.min(b).min(c) - within_m || point_m[k] > a.max(b).max(c) + within_m
        };
        if (0..3).any(outside) {
            continue;
        }
        let at = nearest_on_triangle(&corners, point_m);
        let distance_m = (corners[0] * at[0] + corners[1] * at[1] + corners[2] * at[2] - point_m).norm();
        if distance_m < within_m || (best.is_none() && distance_m <= reach_m) {
            best = Some(Nearest { triangle, at, distance_m });
        }
    }
    best
}
