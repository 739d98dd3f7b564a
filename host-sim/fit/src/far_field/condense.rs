//! Computes the stiffness of the outside at the rim of a patch by quadratic finite elements that
//! are linearised about rest; all degrees of freedom except those of the rim are condensed out.
//!
//! Faces on the rim remain piecewise linear, like those of the patch's tets: the middle node of a
//! rim edge follows the mean of the ends of the edge.

use std::collections::HashMap;

use faer::Mat;
use nalgebra::Vector3;

use super::cut::Outside;
use crate::reference::body::{Body, Stiffness};
use crate::reference::condensed::{Tie, condensed};
use crate::reference::quadratic::QuadraticMesh;
use crate::reference::shape::{TET_EDGES, TetRule};

/// Stiffness of the outside over E [m], shape [3 rim nodes][3 rim nodes]; `None` if there is not
/// enough memory.
#[must_use]
pub fn condense(outside: &Outside, poisson_ratio: f64) -> Option<Mat<f64>> {
    let corners = outside.mesh.nodes_m.len();
    let mesh = QuadraticMesh::new(&outside.mesh);
    let mut middle = HashMap::new();
    for tet in &mesh.tets {
        for (e, [i, j]) in TET_EDGES.into_iter().enumerate() {
            middle.insert(pair(tet[i], tet[j]), tet[4 + e] as usize);
        }
    }
    let mut tie = vec![Tie::Free; mesh.nodes_m.len()];
    for (k, n) in outside.rim.iter().enumerate() {
        tie[*n as usize] = Tie::To(vec![(k, 1.0)]);
    }
    for (face, place) in outside.rim_faces.iter().zip(&outside.rim_triangles) {
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            if let Some(at) = middle.get(&pair(face[i], face[j])) {
                tie[*at] = Tie::To([place[i], place[j]].into_iter().flatten().map(|k| (k, 0.5)).collect());
            }
        }
    }
    let fixed = fixed(&mesh, corners, &outside.anchors);
    let of_tet = |t: usize, _: &Vector3<f64>| Stiffness { ratio: outside.stiffness_ratio[t], poisson_ratio, stiffening_b: 0.0 };
    let body = Body::with_stiffness(mesh, of_tet, fixed, Vec::new(), 1.0, TetRule::Four);
    condensed(&body, &tie, outside.rim.len())
}

/// Marks the anchored corners, and the middle nodes of edges between two of them.
pub(super) fn fixed(mesh: &QuadraticMesh, corners: usize, anchors: &[u32]) -> Vec<[bool; 3]> {
    let mut fixed = vec![[false; 3]; mesh.nodes_m.len()];
    anchors.iter().for_each(|a| fixed[*a as usize] = [true; 3]);
    for tet in &mesh.tets {
        for (e, [i, j]) in TET_EDGES.into_iter().enumerate() {
            let both = [tet[i], tet[j]].iter().all(|n| (*n as usize) < corners && anchors.binary_search(n).is_ok());
            fixed[tet[4 + e] as usize] = [both; 3];
        }
    }
    fixed
}

fn pair(i: u32, j: u32) -> [u32; 2] {
    [i.min(j), i.max(j)]
}
