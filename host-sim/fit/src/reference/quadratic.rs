//! A tet mesh with an additional node in the middle of every edge.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::shape::{TET_EDGES, TRIANGLE_EDGES};
use palpate_tissue::mesh::{TetMesh, surface};

/// 10-node tets and the 6-node triangles of their surface.
#[derive(Clone, Debug)]
pub struct QuadraticMesh {
    /// Rest position of every node [m]: the corners in the order of the tet mesh, then the
    /// nodes in the middle of the edges.
    pub nodes_m: Vec<Vector3<f64>>,
    /// Nodes of every tet, shape \[tets\]\[10\], in the order of [`super::shape`].
    pub tets: Vec<[u32; 10]>,
    /// Nodes of every surface triangle, counter-clockwise seen from outside, shape
    /// \[triangles\]\[6\].
    pub triangles: Vec<[u32; 6]>,
}

impl QuadraticMesh {
    /// Adds a node in the middle of every edge.
    #[must_use]
    pub fn new(mesh: &TetMesh) -> Self {
        let mut nodes_m: Vec<Vector3<f64>> = mesh.nodes_m.iter().map(|x| Vector3::from(*x)).collect();
        let mut middles = HashMap::new();
        let mut middle = |i: u32, j: u32| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                nodes_m.push((nodes_m[i as usize] + nodes_m[j as usize]) * 0.5);
                nodes_m.len() as u32 - 1
            })
        };
        let tets = mesh.tets.iter().map(|t| {
            let mut nodes = [0; 10];
            nodes[..4].copy_from_slice(t);
            for (e, [i, j]) in TET_EDGES.into_iter().enumerate() {
                nodes[4 + e] = middle(t[i], t[j]);
            }
            nodes
        });
        let tets = tets.collect();
        let triangles = surface::surface(&mesh.tets).into_iter().map(|t| {
            let mut nodes = [0; 6];
            nodes[..3].copy_from_slice(&t);
            for (s, [i, j]) in TRIANGLE_EDGES.into_iter().enumerate() {
                nodes[3 + s] = middle(t[i], t[j]);
            }
            nodes
        });
        let triangles = triangles.collect();
        Self { nodes_m, tets, triangles }
    }
}
