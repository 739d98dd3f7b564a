//! The meshed tissue, before it becomes a patch.

use crate::mesh::{TetMesh, surface};

/// A mesh ready to become a patch.
#[derive(Clone, Debug)]
pub struct Tissue {
    /// The mesh.
    pub mesh: TetMesh,
    /// Stiffness of each tet as a multiple of the tissue's, shape \[tets\].
    pub stiffness_ratio: Vec<f64>,
    /// The surface that a probe can touch, counter-clockwise seen from outside.
    pub skin: Vec<[u32; 3]>,
    /// Fixed nodes, ascending.
    pub anchors: Vec<u32>,
    /// Place of the press, on the rest surface [m].
    pub site_m: [f64; 3],
    /// Deepest press that the patch must answer [m].
    pub depth_limit_m: f64,
}

impl Tissue {
    /// A tissue that can be touched on all sides.
    #[must_use]
    pub fn closed(mesh: TetMesh, stiffness_ratio: Vec<f64>, anchors: Vec<u32>, site_m: [f64; 3], depth_limit_m: f64) -> Self {
        let skin = surface::surface(&mesh.tets);
        Self { mesh, stiffness_ratio, skin, anchors, site_m, depth_limit_m }
    }
}

/// A spring between nodes that share no tet, to join two organs (paper 000, "repulsive springs").
/// Its rest length is their distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Ends.
    pub nodes: [u32; 2],
    /// Stiffness over E [m].
    pub k_m: f64,
}
