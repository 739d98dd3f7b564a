//! A suspended body with its weight, its ties and its gripped nodes: energy, residual and tangent.
//!
//! Gravity is a dead load, applied as the consistent nodal forces of the 10-node tet; ties are
//! described in [`super::tie`].

use nalgebra::Vector3;
use thiserror::Error;

use super::tie::Tie;
use palpate_fit::reference::body::{Assembled, Body};
use palpate_fit::reference::shape::tet_slopes;

/// Share of a tet's weight at each corner and at each midpoint of an edge (1): the integrals of the
/// shape functions.
const CORNER_SHARE: f64 = -0.05;
const MIDDLE_SHARE: f64 = 0.2;
/// Force below which forces count as zero, over Young's modulus times the squared size of the body
/// (1).
const NO_FORCE: f64 = 1e-6;

/// Error of a suspension: why its input is invalid, or why it has no equilibrium.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "each message says what its fields are")]
pub enum HangError {
    #[error("densities_kg_per_m3 has {given} values for {tets} tets: give one for each tet")]
    Densities { given: usize, tets: usize },
    #[error("density of tet {tet} = {value} kg/m^3: must be finite and not below 0")]
    Density { tet: usize, value: f64 },
    #[error("youngs_modulus_pa = {value}: must be finite and above 0")]
    Modulus { value: f64 },
    #[error("tie {tie} names node {node} of {nodes}: build ties on the mesh that hangs")]
    Tie { tie: usize, node: u32, nodes: usize },
    #[error("grip names node {node} of {nodes}: use nodes of the mesh that hangs")]
    Grip { node: u32, nodes: usize },
    #[error("grip displacements: {given} values for {nodes} gripped nodes; give one finite vector for each, in their order")]
    Moves { given: usize, nodes: usize },
    #[error("no node is fixed or gripped: hold the organs somewhere, they would fall")]
    Loose,
    #[error("not enough memory for the factor of {nodes} nodes: use a coarser mesh")]
    Memory { nodes: usize },
    #[error(
        "no rest found beyond {share:.4} of the way to weight {weight_share} and the grip's place: use smaller moves or a finer mesh"
    )]
    Stalled { share: f64, weight_share: f64 },
}

/// A suspended body: its mesh and material, its weight, its ties, and the nodes that are gripped
/// and moved.
pub struct Suspension {
    pub(super) body: Body,
    weight_m2: Vec<Vector3<f64>>,
    ties: Vec<Tie>,
    pub(super) grip: Vec<u32>,
    pub(super) no_force_m2: f64,
}

impl Suspension {
    /// A body without weight; its fixed components keep their values.
    pub fn new(body: Body) -> Self {
        let mesh = &body.mesh;
        let corners = |t: &[u32; 10]| [0, 1, 2, 3].map(|k| mesh.nodes_m[t[k] as usize]);
        let volume_m3: f64 = mesh.tets.iter().map(|t| tet_slopes(corners(t)).1).sum();
        let weight_m2 = vec![Vector3::zeros(); mesh.nodes_m.len()];
        Self { no_force_m2: NO_FORCE * volume_m3.cbrt().powi(2), body, weight_m2, ties: vec![], grip: vec![] }
    }

    /// Gives every tet a density [kg/m^3] under a gravity [m/s^2]; the stiffness ratios of the body
    /// are relative to `youngs_modulus_pa`.
    pub fn with_weight(
        mut self,
        densities_kg_per_m3: &[f64],
        gravity_m_per_s2: Vector3<f64>,
        youngs_modulus_pa: f64,
    ) -> Result<Self, HangError> {
        let mesh = &self.body.mesh;
        if densities_kg_per_m3.len() != mesh.tets.len() {
            return Err(HangError::Densities { given: densities_kg_per_m3.len(), tets: mesh.tets.len() });
        }
        if !(youngs_modulus_pa.is_finite() && youngs_modulus_pa > 0.0) {
            return Err(HangError::Modulus { value: youngs_modulus_pa });
        }
        for (t, (tet, density)) in mesh.tets.iter().zip(densities_kg_per_m3).enumerate() {
            if !(density.is_finite() && *density >= 0.0) {
                return Err(HangError::Density { tet: t, value: *density });
            }
            let (_, volume_m3) = tet_slopes([0, 1, 2, 3].map(|k| mesh.nodes_m[tet[k] as usize]));
            let weight_m2 = gravity_m_per_s2 * (density * volume_m3 / youngs_modulus_pa);
            for (k, n) in tet.iter().enumerate() {
                self.weight_m2[*n as usize] += weight_m2 * if k < 4 { CORNER_SHARE } else { MIDDLE_SHARE };
            }
        }
        Ok(self)
    }

    /// Adds ties between surfaces.
    pub fn with_ties(mut self, ties: Vec<Tie>) -> Result<Self, HangError> {
        let nodes = self.body.mesh.nodes_m.len();
        for (tie, node) in ties.iter().enumerate().flat_map(|(index, tie)| tie.nodes.map(|n| (index, n))) {
            if node as usize >= nodes {
                return Err(HangError::Tie { tie, node, nodes });
            }
        }
        self.ties.extend(ties);
        let groups: Vec<[u32; 12]> = self.ties.iter().map(|tie| tie.nodes).collect();
        self.body.couple(&groups);
        Ok(self)
    }

    /// Grips nodes whose displacement will be prescribed; it is zero until they are moved.
    pub fn with_grip(mut self, nodes: &[u32]) -> Result<Self, HangError> {
        let count = self.body.mesh.nodes_m.len();
        for node in nodes {
            let fixed = self.body.fixed.get_mut(*node as usize).ok_or(HangError::Grip { node: *node, nodes: count })?;
            *fixed = [true; 3];
        }
        self.grip.extend_from_slice(nodes);
        Ok(self)
    }

    /// Body that is suspended; gripped nodes count as fixed.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// Ties between surfaces of the body.
    pub fn ties(&self) -> &[Tie] {
        &self.ties
    }

    /// Sum of the nodal weights over Young's modulus [m^2].
    pub fn weight_m2(&self) -> Vector3<f64> {
        self.weight_m2.iter().sum()
    }

    /// Energy over Young's modulus [m^3] with a share of the weight; `None` if an element is
    /// inverted.
    pub fn energy_m3(&self, displacement_m: &[Vector3<f64>], weight_share: f64) -> Option<f64> {
        let elastic = self.body.energy(displacement_m, None)?;
        let tied: f64 = self.ties.iter().map(|tie| tie.energy_m3(displacement_m)).sum();
        let falls: f64 = self.weight_m2.iter().zip(displacement_m).map(|(w, u)| w.dot(u)).sum();
        Some(elastic + tied - weight_share * falls)
    }

    /// Energy, residual and tangent with a share of the weight; `None` if an element is inverted.
    pub fn assemble(&self, displacement_m: &[Vector3<f64>], weight_share: f64) -> Option<Assembled> {
        self.derive(displacement_m, weight_share, true)
    }

    pub(super) fn derive(&self, displacement_m: &[Vector3<f64>], weight_share: f64, tangent: bool) -> Option<Assembled> {
        let mut sum = self.body.derive(displacement_m, tangent)?;
        for tie in &self.ties {
            tie.add(displacement_m, &self.body.pattern, &mut sum);
        }
        for ((residual, w), u) in sum.residual_m2.iter_mut().zip(&self.weight_m2).zip(displacement_m) {
            *residual -= w * weight_share;
            sum.energy_m3 -= weight_share * w.dot(u);
        }
        Some(sum)
    }
}
