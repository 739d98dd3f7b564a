//! Builds a patch from a tet mesh: rest data per pascal of Young's modulus, computed in `f64` and
//! rounded at the end.
//!
//! A patch has springs (paper 000, eq 11, times `1/(0.8 (1 + nu))`, so that their shear modulus is
//! the tissue's), nodal and per-tet volume stiffness for the remainder, foundation points on the
//! surface, and masses. Calibration fits multipliers for each edge, node and foundation point.

mod foundation;
mod neighbours;
mod order;
mod rim;
mod stiffness;

use std::collections::BTreeMap;

use palpate::{
    Bristle, Faded, FoundationPoint, LAW_FIELDS, Law, LawShape, Model, Node, NodeRest, NodeStep, Params, PatchFile, RimEdge,
    RimNode, Spring, State, Tet, TetShapes, Triangle, Tuned, Vector3,
};

use crate::mesh::TetMesh;
use crate::mesh::quality::element_size;
use crate::scene::Inclusion;
use crate::tissue::{Joint, Tissue, ratio_of};
pub use rim::RimSprings;
use stiffness::Elastic;

/// Positive factors on the values that the formulas give; all are 1 without calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct Multipliers {
    /// Multiplier of each spring, in the order of [`surface::edges`], shape \[edges\].
    pub edge: Vec<f64>,
    /// Multiplier of each node's volume stiffness, shape \[nodes\].
    pub node: Vec<f64>,
    /// Multiplier of each foundation point, shape [skin triangles][points], triangles in the order
    /// of [`Tissue::skin`].
    pub point: Vec<Vec<f64>>,
    /// Multiplier of the volume stiffness that acts per tet.
    pub bulk: f64,
    /// Multiplier of the foundation's stiffening.
    pub stiffening: f64,
}

impl Multipliers {
    /// Returns the product of two sets of factors.
    #[must_use]
    pub fn times(&self, other: &Self) -> Self {
        let all = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
        Self {
            edge: all(&self.edge, &other.edge),
            node: all(&self.node, &other.node),
            point: self.point.iter().zip(&other.point).map(|(a, b)| all(a, b)).collect(),
            bulk: self.bulk * other.bulk,
            stiffening: self.stiffening * other.stiffening,
        }
    }
}

/// Constants of the material model that do not scale with E.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Poisson's ratio (1).
    pub poisson_ratio: f64,
    /// Share of the volume stiffness that acts per tet, beta (1).
    pub per_tet_share: f64,
    /// Foundation stiffness per area, times element size, over E (1).
    pub foundation_stiffness: f64,
    /// Foundation stiffening times element size (1).
    pub foundation_stiffening: f64,
    /// Foundation points on a triangle: 4, 9 or, not for boards, 16.
    pub points_per_triangle: usize,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            poisson_ratio: 0.45,
            per_tet_share: 0.109,
            foundation_stiffness: 3.0,
            foundation_stiffening: 2.0,
            points_per_triangle: 4,
        }
    }
}

/// A law that owns its table.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnLaw {
    /// Constants.
    pub shape: LawShape,
    /// Control values of the splines, shape \[side, side\].
    pub table: Vec<[f32; LAW_FIELDS]>,
}

/// A patch that owns its arrays.
#[derive(Clone, Debug)]
pub struct Patch {
    poisson_ratio: f32,
    stiffening_per_m: f32,
    depth_limit_m: f32,
    site_m: [f32; 3],
    element_m: f64,
    fitted_places: u32,
    /// Whether inclusions were scaled into a fitted patch. If so, its file no longer counts as a
    /// patch of the homogeneous block.
    scaled: bool,
    nodes: Vec<NodeRest>,
    anchors: Vec<u16>,
    spring_rows: Vec<u16>,
    springs: Vec<Spring>,
    scheduled: Vec<Spring>,
    tets: Vec<Tet>,
    neighbours: Vec<[u32; 4]>,
    triangles: Vec<Triangle>,
    steepness: Vec<f32>,
    owners: Vec<u32>,
    foundation: Vec<FoundationPoint>,
    rim_nodes: Vec<RimNode>,
    rim_edges: Vec<RimEdge>,
    law: Option<OwnLaw>,
}

impl Patch {
    /// Builds the patch of a tissue. The mesh must have passed its check, which refuses more than
    /// 65 535 nodes.
    #[must_use]
    pub fn build(tissue: &Tissue, material: &Material, multipliers: Option<&Multipliers>) -> Self {
        Self::build_joined(tissue, material, multipliers, &[])
    }

    /// Builds the patch of a tissue as [`Self::build`] does, with springs that join nodes of
    /// different organs. The two nodes of such a spring must not coincide.
    #[must_use]
    pub fn build_joined(tissue: &Tissue, material: &Material, multipliers: Option<&Multipliers>, joints: &[Joint]) -> Self {
        let elastic = Elastic::of(tissue, material, multipliers, joints);
        let law = foundation::of(tissue, material, multipliers);
        let nodes = elastic.nodes(&tissue.mesh);
        let (springs, spring_rows) = order::rows(&elastic.springs, nodes.len());
        let tets = order::interleave(&elastic.tets);
        let (neighbours, owners) = neighbours::of(&tets, &law.triangles);
        Self {
            poisson_ratio: material.poisson_ratio as f32,
            stiffening_per_m: law.stiffening_per_m as f32,
            depth_limit_m: tissue.depth_limit_m as f32,
            site_m: tissue.site_m.map(|c| c as f32),
            element_m: law.element_m,
            fitted_places: 0,
            scaled: false,
            anchors: tissue.anchors.iter().map(|&a| a as u16).collect(),
            scheduled: order::schedule(&springs),
            tets,
            neighbours,
            owners,
            nodes,
            spring_rows,
            springs,
            triangles: law.triangles,
            steepness: Vec::new(),
            foundation: law.points,
            rim_nodes: Vec::new(),
            rim_edges: Vec::new(),
            law: None,
        }
    }

    /// A law and the rest shape of a tissue, without anything that deforms. The mesh may be as
    /// coarse as its surface allows: it only says where the tissue is.
    #[must_use]
    pub fn of_law(rest: &Tissue, poisson_ratio: f64, law: OwnLaw) -> Self {
        let material = Material { poisson_ratio, ..Material::default() };
        Self {
            spring_rows: Vec::new(),
            springs: Vec::new(),
            scheduled: Vec::new(),
            foundation: Vec::new(),
            law: Some(law),
            ..Self::build(rest, &material, None)
        }
    }

    /// Copies the patch out of a patch file.
    #[must_use]
    pub fn of_file(file: &PatchFile) -> Self {
        let model = &file.model;
        let areas = model.triangles.iter().map(|t| {
            let [a, b, c] = t.node.map(|n| Vector3::from(model.nodes[usize::from(n)].rest_m).cast::<f64>());
            let from_site = ((a + b + c) / 3.0 - file.site_m.cast()).norm_squared();
            (from_site, (b - a).cross(&(c - a)).norm() / 2.0)
        });
        let nearest = areas.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, area)| area);
        Self {
            poisson_ratio: model.poisson_ratio,
            stiffening_per_m: model.stiffening_per_m,
            depth_limit_m: model.depth_limit_m,
            site_m: file.site_m.into(),
            element_m: element_size(nearest),
            fitted_places: file.fitted_places,
            scaled: false,
            nodes: model.nodes.to_vec(),
            anchors: model.anchors.to_vec(),
            spring_rows: model.spring_rows.to_vec(),
            springs: model.springs.to_vec(),
            scheduled: order::schedule(model.springs),
            tets: model.tets.to_vec(),
            neighbours: model.neighbours.to_vec(),
            owners: model.owners.to_vec(),
            triangles: model.triangles.to_vec(),
            steepness: model.steepness.to_vec(),
            foundation: model.foundation.to_vec(),
            rim_nodes: model.rim_nodes.to_vec(),
            rim_edges: model.rim_edges.to_vec(),
            law: model.law.map(|law| OwnLaw { shape: *law.shape, table: law.table.to_vec() }),
        }
    }

    /// Mesh of the patch, with positions as they were rounded for the core.
    #[must_use]
    pub fn mesh(&self) -> TetMesh {
        TetMesh {
            nodes_m: self.nodes.iter().map(|n| n.rest_m.map(f64::from)).collect(),
            tets: self.tets.iter().map(|t| t.node.map(u32::from)).collect(),
            regions: vec![0; self.tets.len()],
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
            neighbours: &self.neighbours,
            owners: &self.owners,
            triangles: &self.triangles,
            steepness: &self.steepness,
            foundation: &self.foundation,
            rim_nodes: &self.rim_nodes,
            rim_edges: &self.rim_edges,
            law: self.law.as_ref().map(|law| Law { shape: &law.shape, table: &law.table }),
        }
    }

    /// The patch as the desktop runs it: springs are scheduled so that neighbours in the list share
    /// no node. The forces are bit-identical.
    #[must_use]
    pub fn wide_model(&self) -> Model<'_> {
        Model { spring_rows: &[], springs: &self.scheduled, ..self.model() }
    }

    /// Site of the press on the rest surface [m].
    #[must_use]
    pub fn site_m(&self) -> Vector3<f32> {
        self.site_m.into()
    }

    /// Position at which the tip touches the site [m]: the site itself, unless the tip is tilted.
    #[must_use]
    pub fn touch_m(&self, params: &Params) -> Vector3<f32> {
        self.site_m() + params.touch_offset_m()
    }

    /// Element size at the site [m]: the side of an equilateral triangle with the area of the
    /// surface triangle nearest to the site.
    #[must_use]
    pub fn element_m(&self) -> f64 {
        self.element_m
    }

    /// Multiplies the weight and the inertia of each node by `ratio`, shape \[nodes\]. The volumes
    /// that resist compression do not change.
    pub fn scale_masses(&mut self, ratio: &[f64]) {
        for (node, ratio) in self.nodes.iter_mut().zip(ratio) {
            node.volume_m3 = (f64::from(node.volume_m3) * ratio) as f32;
        }
    }

    /// Sets the steepness with which the tissue stiffens at each node: see [`Model::steepness`].
    pub fn set_steepness(&mut self, steepness: Vec<f32>) {
        self.steepness = steepness;
    }

    /// Moves the site of the press [m].
    pub fn set_site_m(&mut self, site_m: [f64; 3]) {
        self.site_m = site_m.map(|c| c as f32);
    }

    /// Returns the patch with balls of another stiffness inside: every constant is multiplied by
    /// the factor by which the balls change its formula.
    #[must_use]
    pub fn with_inclusions(mut self, inclusions: &[Inclusion]) -> Self {
        if inclusions.is_empty() {
            return self;
        }
        let build = |inclusions: &[Inclusion]| {
            let mesh = self.mesh();
            let stiffness_ratio = mesh.tets.iter().map(|tet| ratio_of(&mesh, tet, inclusions)).collect();
            let material = Material {
                poisson_ratio: f64::from(self.poisson_ratio),
                points_per_triangle: self.model().points_per_triangle(),
                ..Material::default()
            };
            let anchors = self.anchors.iter().map(|&a| a.into()).collect();
            let site_m = self.site_m.map(f64::from);
            let skin = self.triangles.iter().map(|t| t.node.map(u32::from)).collect();
            let tissue = Tissue { mesh, stiffness_ratio, skin, anchors, site_m, depth_limit_m: self.depth_limit_m.into() };
            Self::build(&tissue, &material, None)
        };
        let (plain, stiffened) = (build(&[]), build(inclusions));
        self.scaled = true;
        for ((own, a), b) in self.springs.iter_mut().zip(&plain.springs).zip(&stiffened.springs) {
            let ratio = b.k / a.k;
            own.k *= ratio;
            own.k_rest *= ratio;
        }
        self.scheduled = order::schedule(&self.springs);
        // the stiffness that the far field adds to a rim node does not scale with the tissue
        let mut rim_m = vec![0.0; self.nodes.len()];
        self.rim_nodes.iter().for_each(|rim| rim_m[rim.node as usize] = mean_diagonal(&rim.block_m));
        for (((own, a), b), rim_m) in self.nodes.iter_mut().zip(&plain.nodes).zip(&stiffened.nodes).zip(rim_m) {
            own.pressure *= b.pressure / a.pressure;
            own.stiffness_m = (own.stiffness_m - rim_m) * (b.stiffness_m / a.stiffness_m) + rim_m;
        }
        let by_node = |tets: &[Tet]| tets.iter().map(|t| (t.node, *t)).collect::<BTreeMap<_, _>>();
        let (plain, stiffened) = (by_node(&plain.tets), by_node(&stiffened.tets));
        for own in &mut self.tets {
            if let (Some(a), Some(b)) = (plain.get(&own.node), stiffened.get(&own.node)) {
                own.bulk *= b.bulk / a.bulk;
                own.barrier *= b.barrier / a.barrier;
            }
        }
        self
    }

    /// The factors that turn the constants of `formula`, an uncalibrated patch on the same mesh,
    /// into those of this patch.
    #[must_use]
    pub fn multipliers_over(&self, formula: &Self) -> Multipliers {
        // at nu = 1/4 the springs alone are the solid, and the volume terms are zero
        let ratio = |own: f32, of: f32| if of == 0.0 { 1.0 } else { f64::from(own) / f64::from(of) };
        let points: Vec<f64> = self.foundation.iter().zip(&formula.foundation).map(|(own, of)| ratio(own.k, of.k)).collect();
        Multipliers {
            edge: self.springs.iter().zip(&formula.springs).map(|(own, of)| ratio(own.k, of.k)).collect(),
            node: self.nodes.iter().zip(&formula.nodes).map(|(own, of)| ratio(own.pressure, of.pressure)).collect(),
            point: points.chunks(self.model().points_per_triangle()).map(<[f64]>::to_vec).collect(),
            bulk: self.tets.iter().zip(&formula.tets).map(|(own, of)| ratio(own.bulk, of.bulk)).next().unwrap_or(1.0),
            stiffening: ratio(self.stiffening_per_m, formula.stiffening_per_m),
        }
    }

    /// Records that inclusions are part of the constants, so that no scene may add them again.
    pub fn set_scaled(&mut self) {
        self.scaled = true;
    }

    /// Number of places at which the constants were fitted; 0 if they come from formulas alone.
    #[must_use]
    pub fn fitted_places(&self) -> u32 {
        self.fitted_places
    }

    /// Replaces the far field around the patch, and leaves all else as it is.
    pub fn set_rim(&mut self, rim: &RimSprings) {
        for old in &self.rim_nodes {
            self.nodes[old.node as usize].stiffness_m -= mean_diagonal(&old.block_m);
        }
        (self.rim_nodes, self.rim_edges) = (Vec::new(), Vec::new());
        for ([i, j], b) in &rim.blocks {
            let [ni, nj] = [i, j].map(|k| rim.node[*k]);
            if i == j {
                let block_m = [b[0][0], b[1][1], b[2][2], b[0][1], b[0][2], b[1][2]].map(|v| v as f32);
                self.nodes[ni as usize].stiffness_m += mean_diagonal(&block_m);
                self.rim_nodes.push(RimNode { node: ni, block_m });
            } else {
                let row = |r: usize| b[r].map(|v| v as f32);
                let [[a, b, c], [d, e, g], [h, k, l]] = [row(0), row(1), row(2)];
                self.rim_edges.push(RimEdge { node: [ni as u16, nj as u16], block_m: [a, b, c, d, e, g, h, k, l] });
            }
        }
    }

    /// Records the number of places at which the constants were fitted.
    pub fn set_fitted_places(&mut self, places: u32) {
        self.fitted_places = places;
    }

    /// Changes the depth limit of the patch [m].
    pub fn set_depth_limit_m(&mut self, depth_limit_m: f32) {
        self.depth_limit_m = depth_limit_m;
    }

    /// Bytes of a patch file with this patch and its parameters.
    #[must_use]
    pub fn pack(&self, params: &Params, stable_dt_s: f32) -> Vec<u8> {
        let mut bytes = Vec::new();
        let file = PatchFile {
            model: self.model(),
            params: *params,
            site_m: self.site_m(),
            stable_dt_s,
            fitted_places: if self.scaled { 0 } else { self.fitted_places },
        };
        file.write(|b| bytes.extend_from_slice(b));
        bytes
    }
}

fn mean_diagonal([xx, yy, zz, ..]: &[f32; 6]) -> f32 {
    (xx + yy + zz) / 3.0
}

/// Memory of a running patch, allocated once; a board reserves the same arrays as statics.
#[derive(Clone, Debug)]
pub struct Memory {
    nodes: Vec<Node>,
    candidates: Vec<u16>,
    shapes: Vec<TetShapes>,
    node_step: Vec<NodeStep>,
    faded: Vec<Faded>,
    bristles: Vec<Bristle>,
}

impl Memory {
    /// Allocates enough memory for a model.
    #[must_use]
    pub fn for_model(model: &Model) -> Self {
        let (nodes, triangles) = (model.nodes.len(), model.triangles.len());
        Self {
            nodes: vec![Node::ZERO; nodes],
            candidates: vec![0; triangles],
            shapes: vec![TetShapes::ZERO; TetShapes::count(model)],
            node_step: vec![NodeStep::ZERO; nodes],
            faded: Vec::new(),
            bristles: Vec::new(),
        }
    }

    /// Starts a patch at rest: returns its derived constants and its state, which borrow this
    /// memory.
    ///
    /// # Errors
    /// Fails if [`Params::build`] rejects the parameters, the model or the memory.
    pub fn start(&mut self, model: &Model, params: &Params) -> Result<(Tuned<'_>, State<'_>), palpate::BuildError> {
        let tuned = params.build(model, &mut self.node_step)?;
        let mut state = State::new(model, &mut self.nodes, &mut self.candidates, &mut self.shapes)?;
        if tuned.relaxes() {
            self.faded.clear();
            self.faded.resize(model.nodes.len(), Faded::ZERO);
            state = state.with_relaxation(&mut self.faded)?;
        }
        if tuned.rubs() {
            self.bristles.clear();
            self.bristles.resize(model.nodes.len(), Bristle::ZERO);
            state = state.with_friction(&mut self.bristles);
        }
        Ok((tuned, state))
    }
}
