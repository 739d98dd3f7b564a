//! Tetrahedral meshes: the built-in graded block, import from files, checks, the surface, and the
//! distance to it.

pub mod block;
mod bytes;
mod check;
mod crossings;
mod distance;
mod element;
mod error;
mod facets;
mod file;
mod gmsh;
pub mod import;
mod lines;
mod pairs;
pub(crate) mod quality;
mod raw;
mod resolve;
mod solid;
pub mod surface;
mod surface_file;
mod topology;
pub mod triangle;
mod unit;
mod up;
mod usd;
mod vtk;
mod word;

pub use block::{BlockError, BlockSpec, block, block_of_at_least, block_with_rim, radius_ratio};
pub use distance::{ClosedSurface, Foot};
pub use error::{Defect, MeshError};
pub use facets::fit_facets;
pub use import::{ImportReport, Imported};
pub(crate) use quality::six_volume;
pub use quality::{WorstTet, worst};
pub use surface_file::{ImportedSurface, SurfaceReport};
pub use unit::LengthUnit;
pub use up::Up;

/// A tetrahedral mesh in metres. Frame: x to the operator, y to the operator's right, z up.
/// Every tet (a, b, c, d) is positively oriented: `(b-a) x (c-a) . (d-a) > 0`.
#[derive(Clone, Debug, PartialEq)]
pub struct TetMesh {
    /// Node positions \[m\], shape \[nodes\]\[3\].
    pub nodes_m: Vec<[f64; 3]>,
    /// Node indices of every tet, shape \[tets\]\[4\].
    pub tets: Vec<[u32; 4]>,
    /// Region (physical group, attribute) of every tet, shape \[tets\]; 0 where the file names
    /// none.
    pub regions: Vec<u32>,
}

impl TetMesh {
    /// Volume of the mesh, the sum over its tets [m^3].
    #[must_use]
    pub fn volume_m3(&self) -> f64 {
        self.tets.iter().map(|&tet| quality::six_volumes(quality::corners(&self.nodes_m, tet))).sum::<f64>() / 6.0
    }
}
