//! From a tet mesh to a patch: rest data per pascal of Young's modulus, in `f64` until the last rounding.
//!
//! Springs (paper 000, eq 11) times `1/(0.8 (1 + nu))`, so that their shear modulus is the tissue's; nodal and per-tet volume stiffness for the
//! rest; foundation points on the surface; masses. Multipliers for each edge, node and surface node are what calibration fits.

mod foundation;
mod order;
mod stiffness;

use palpate::{FoundationPoint, Model, Node, NodeRest, Params, PatchFile, RimEdge, RimNode, Spring, State, Tet, Triangle, Tuned, Vector3};

use crate::mesh::{TetMesh, surface};
use stiffness::Elastic;

/// Positive factors on what the formulas give; all 1 without calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct Multipliers {
    /// On each spring, in the order of [`surface::edges`], shape \[edges\].
    pub edge: Vec<f64>,
    /// On each node's volume stiffness, shape \[nodes\].
    pub node: Vec<f64>,
    /// On the foundation at each surface node, shape \[nodes\] (inner nodes unused).
    pub surface_node: Vec<f64>,
}

/// Constants of the material model that do not scale with E.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Poisson's ratio (1).
    pub poisson_ratio: f64,
    /// Share of the volume stiffness that acts per tet (beta).
    pub per_tet_share: f64,
    /// Foundation stiffness times element size over E (1).
    pub foundation_stiffness: f64,
    /// Foundation stiffening times element size (1).
    pub foundation_stiffening: f64,
}

impl Default for Material {
    fn default() -> Self {
        Self { poisson_ratio: 0.45, per_tet_share: 0.109, foundation_stiffness: 0.926, foundation_stiffening: 13.1 }
    }
}

/// A mesh ready to become a patch.
#[derive(Clone, Debug)]
pub struct Tissue {
    /// The mesh.
    pub mesh: TetMesh,
    /// Stiffness of each tet as a multiple of the tissue's, shape \[tets\].
    pub stiffness_ratio: Vec<f64>,
    /// Fixed nodes, ascending.
    pub anchors: Vec<u32>,
    /// Where the probe presses, on the rest surface [m].
    pub site_m: [f64; 3],
    /// Deepest press that the patch must answer [m].
    pub depth_limit_m: f64,
}

/// A patch that owns its arrays.
#[derive(Clone, Debug)]
pub struct Patch {
    poisson_ratio: f32,
    stiffening_per_m: f32,
    depth_limit_m: f32,
    site_m: [f32; 3],
    nodes: Vec<NodeRest>,
    anchors: Vec<u16>,
    spring_rows: Vec<u16>,
    springs: Vec<Spring>,
    scheduled: Vec<Spring>,
    tets: Vec<Tet>,
    triangles: Vec<Triangle>,
    foundation: Vec<[FoundationPoint; 4]>,
    rim_nodes: Vec<RimNode>,
    rim_edges: Vec<RimEdge>,
}

impl Patch {
    /// Builds the patch of a tissue. The mesh must have passed its check; more than 65 535 nodes are refused there.
    #[must_use]
    pub fn build(tissue: &Tissue, material: &Material, multipliers: Option<&Multipliers>) -> Self {
        let elastic = Elastic::of(tissue, material, multipliers);
        let triangles = surface::surface(&tissue.mesh.tets);
        let law = foundation::of(tissue, material, multipliers, &triangles);
        let nodes = elastic.nodes(&tissue.mesh, &law.contact_m);
        let (springs, spring_rows) = order::rows(&elastic.springs, nodes.len());
        Self {
            poisson_ratio: material.poisson_ratio as f32,
            stiffening_per_m: law.stiffening_per_m as f32,
            depth_limit_m: tissue.depth_limit_m as f32,
            site_m: tissue.site_m.map(|c| c as f32),
            anchors: tissue.anchors.iter().map(|&a| a as u16).collect(),
            scheduled: order::schedule(&springs),
            tets: order::interleave(&elastic.tets),
            nodes,
            spring_rows,
            springs,
            triangles: law.triangles,
            foundation: law.points,
            rim_nodes: Vec::new(),
            rim_edges: Vec::new(),
        }
    }

    /// The patch as the board runs it: springs in rows.
    #[must_use]
    pub fn model(&self) -> Model<'_> {
        Model {
            poisson_ratio: self.poisson_ratio,
            stiffening_per_m: self.stiffening_per_m,
            depth_limit_m: self.depth_limit_m,
            nodes: &self.nodes,
            anchors: &self.anchors,
            spring_rows: &self.spring_rows,
            springs: &self.springs,
            tets: &self.tets,
            triangles: &self.triangles,
            foundation: &self.foundation,
            rim_nodes: &self.rim_nodes,
            rim_edges: &self.rim_edges,
        }
    }

    /// The patch as the desktop runs it: springs scheduled so that neighbours in the list share no node. Same bits.
    #[must_use]
    pub fn wide_model(&self) -> Model<'_> {
        Model { spring_rows: &[], springs: &self.scheduled, ..self.model() }
    }

    /// Site of the press on the rest surface [m].
    #[must_use]
    pub fn site_m(&self) -> Vector3<f32> {
        self.site_m.into()
    }

    /// Changes the deepest press the patch answers [m].
    pub fn set_depth_limit_m(&mut self, depth_limit_m: f32) {
        self.depth_limit_m = depth_limit_m;
    }

    /// Bytes of the patch file.
    #[must_use]
    pub fn pack(&self, params: &Params, stable_dt_s: f32) -> Vec<u8> {
        let mut bytes = Vec::new();
        PatchFile { model: self.model(), params: *params, site_m: self.site_m(), stable_dt_s }.write(|b| bytes.extend_from_slice(b));
        bytes
    }
}

/// Memory of a running patch: what the board reserves in statics, allocated once.
#[derive(Clone, Debug)]
pub struct Memory {
    nodes: Vec<Node>,
    pressure: Vec<f32>,
    candidates: Vec<u16>,
    node_step: Vec<f32>,
    cap_m: Vec<f32>,
}

impl Memory {
    /// Enough for a model.
    #[must_use]
    pub fn for_model(model: &Model) -> Self {
        let (nodes, triangles) = (model.nodes.len(), model.triangles.len());
        Self {
            nodes: vec![Node::ZERO; nodes],
            pressure: vec![0.0; nodes],
            candidates: vec![0; triangles],
            node_step: vec![0.0; nodes],
            cap_m: vec![0.0; triangles],
        }
    }

    /// Splits into the two halves of a running patch.
    ///
    /// # Errors
    /// What [`Params::build`] refuses.
    pub fn start(&mut self, model: &Model, params: &Params) -> Result<(Tuned<'_>, State<'_>), palpate::BuildError> {
        let tuned = params.build(model, &mut self.node_step, &mut self.cap_m)?;
        let state = State::new(model, &mut self.nodes, &mut self.pressure, &mut self.candidates)?;
        Ok((tuned, state))
    }
}
