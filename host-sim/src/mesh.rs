//! Tetrahedral meshes: the type, and the built-in graded block.

pub mod block;
mod delaunay;
mod flip;
mod grading;
mod quality;
mod relax;
mod seed;
mod sliver;
mod vector;

pub use block::{BlockError, BlockSpec, block};
pub use quality::radius_ratio;

/// A tetrahedral mesh in metres. Frame: x to the operator, y to the operator's right, z up.
/// Every tet (a, b, c, d) is positively oriented: `(b-a) x (c-a) . (d-a) > 0`.
#[derive(Clone, Debug, PartialEq)]
pub struct TetMesh {
    /// Node positions [m], shape [nodes][3].
    pub nodes_m: Vec<[f64; 3]>,
    /// Node indices of every tet, shape [tets][4].
    pub tets: Vec<[u32; 4]>,
    /// Region (physical group, attribute) of every tet, shape [tets]; 0 where the file names none.
    pub regions: Vec<u32>,
}
pub mod surface;
