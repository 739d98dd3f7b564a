//! The standard block that every method presses.

use palpate::{Params, ProbeShape, Vector3};

use palpate_tissue::error::Error;
use palpate_tissue::mesh::{BlockSpec, TetMesh, block};
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::{Inclusion, SceneError};
use palpate_tissue::tissue::{DEPTH_MARGIN, Tissue, ratio_of};

/// Sides of the block [m]; its bottom is fixed, and its top is at z = 0.
pub const BLOCK_M: [f64; 3] = [0.08, 0.08, 0.04];
/// Radius of the hemisphere over the centre of the top [m].
pub const RADIUS_M: f64 = 8e-3;
/// Depth of the deepest press [m].
pub const DEEPEST_M: f64 = 8e-3;

/// A tissue with the parameters that all methods share.
#[derive(Clone, Debug)]
pub struct Block {
    /// Mesh, anchors and site of the press.
    pub tissue: Tissue,
    /// Stiffness, density, damping, mass floor and probe.
    pub params: Params,
    /// Number of parts into which each substep is split; the mass floor is that of the shorter
    /// substeps.
    pub refinement: u16,
    /// Contact dashpot that replaces that of the calibrated patch [substeps]; see
    /// [`Params::contact_damping`].
    pub contact_damping: Option<f32>,
    /// Balls of another stiffness inside.
    pub inclusions: Vec<Inclusion>,
    /// Deepest press that a method must survive [m].
    pub deepest_m: f64,
    /// Law and patch that were fitted to this tissue, in place of those of the standard block.
    pub fitted: Fitted,
}

/// Law or patch that was fitted to a tissue.
#[derive(Clone, Debug, Default)]
pub struct Fitted {
    /// Law.
    pub law: Option<Patch>,
    /// Calibrated patch, with the parameters that were fitted with it.
    pub patch: Option<(Patch, Params)>,
}

/// Numbers of nodes, edges and tets, on which costs depend.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Size {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of tets.
    pub tets: usize,
}

impl Block {
    /// The standard block with an exact number of nodes.
    pub fn standard(nodes: usize, youngs_modulus_pa: f64) -> Result<Self, Error> {
        let spec = BlockSpec { size_m: BLOCK_M, nodes, fine_at_m: [0.0; 2], fine_radius_m: RADIUS_M };
        let mesh = block(&spec).map_err(|cause| SceneError::value("chart", "nodes:", &cause.to_string()))?;
        Ok(Self::of_mesh(mesh, youngs_modulus_pa, |x| x[2] <= -BLOCK_M[2] * (1.0 - 1e-9)))
    }

    /// The standard block on the mesh of the shipped patch of this size, if there is one.
    pub fn calibrated(nodes: usize, youngs_modulus_pa: f64) -> Option<Self> {
        let (patch, _) = palpate_tissue::session::calibrated::sized(nodes)?;
        Some(Self::of_mesh(patch.mesh(), youngs_modulus_pa, |x| x[2] <= -BLOCK_M[2] * (1.0 - 1e-6)))
    }

    /// Any mesh under the standard probe, pressed at the origin; `fixed` selects the anchors by
    /// their rest position [m].
    pub fn of_mesh(mesh: TetMesh, youngs_modulus_pa: f64, fixed: impl Fn(&[f64; 3]) -> bool) -> Self {
        let anchors = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| fixed(x)).map(|(n, _)| n).collect();
        let stiffness_ratio = vec![1.0; mesh.tets.len()];
        let tissue = Tissue::closed(mesh, stiffness_ratio, anchors, [0.0; 3], DEPTH_MARGIN * DEEPEST_M);
        let mut params = Params { youngs_modulus_pa: youngs_modulus_pa as f32, ..Params::default() };
        params.probe.shape = ProbeShape::Hemisphere;
        params.probe.radius_m = RADIUS_M as f32;
        Self::of_tissue(tissue, params)
    }

    /// Any tissue under the probe of these parameters.
    pub fn of_tissue(tissue: Tissue, params: Params) -> Self {
        Self {
            tissue,
            params,
            refinement: 1,
            contact_damping: None,
            inclusions: Vec::new(),
            deepest_m: DEEPEST_M,
            fitted: Fitted::default(),
        }
    }

    /// Returns the block with a stiffer or softer ball inside.
    pub fn with_inclusion(mut self, ball: Inclusion) -> Self {
        let mesh = &self.tissue.mesh;
        self.tissue.stiffness_ratio = mesh.tets.iter().map(|tet| ratio_of(mesh, tet, &[ball])).collect();
        self.inclusions.push(ball);
        self
    }

    /// Returns the block with every substep split into this many parts.
    pub fn refined(mut self, refinement: u16) -> Self {
        self.refinement = refinement;
        self
    }

    /// Tissue of the block with any inclusion removed.
    pub fn even_tissue(&self) -> Tissue {
        Tissue { stiffness_ratio: vec![1.0; self.tissue.mesh.tets.len()], ..self.tissue.clone() }
    }

    /// Counts the nodes, edges and tets.
    pub fn size(&self) -> Size {
        let mesh = &self.tissue.mesh;
        Size { nodes: mesh.nodes_m.len(), edges: palpate_tissue::mesh::surface::edges(&mesh.tets).len(), tets: mesh.tets.len() }
    }

    /// First and second Lamé constants, divided by E (1).
    pub fn lame_over_modulus(&self) -> (f64, f64) {
        let nu = f64::from(self.params.poisson_ratio);
        (nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), 0.5 / (1.0 + nu))
    }

    /// Whether each node is fixed, shape \[nodes\].
    pub fn fixed(&self) -> Vec<bool> {
        let mut fixed = vec![false; self.tissue.mesh.nodes_m.len()];
        self.tissue.anchors.iter().for_each(|&n| fixed[n as usize] = true);
        fixed
    }

    /// Position of the tip [m] when it is `depth_m` below the site.
    pub fn tip_m(&self, depth_m: f64) -> Vector3<f32> {
        Vector3::from(self.tissue.site_m.map(|c| c as f32)) - self.params.probe.axis * depth_m as f32
    }
}
