//! The meshed tissue, before it becomes a patch.

use crate::mesh::{TetMesh, surface};

/// A mesh with all that is needed to make a patch of it.
#[derive(Clone, Debug)]
pub struct Tissue {
    /// Tetrahedral mesh of the whole tissue.
    pub mesh: TetMesh,
    /// Stiffness of each tet over that of the tissue (1), shape \[tets\].
    pub stiffness_ratio: Vec<f64>,
    /// Surface triangles that a probe can touch, counter-clockwise seen from outside.
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
/// Its rest length is the distance between these nodes at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Nodes at the two ends.
    pub nodes: [u32; 2],
    /// Stiffness divided by Young's modulus [m].
    pub k_m: f64,
}
