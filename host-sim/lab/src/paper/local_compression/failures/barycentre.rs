//! The volume force (2): the net force that it exerts on an isolated tet, and the effect of its
//! coefficient on the force of a press.

use crate::paper_method::LocalCompression;
use crate::paper_method::barycentre::BarycentreForce;
use crate::paper_method::velocity_verlet::VelocityVerlet;
use palpate::{Model, Vector3};

use super::super::methods::{Fitted, StudyMethod, springs_of};
use super::super::steps::hold;
use crate::error::Error;
use crate::methods::{Block, OnCore};
use palpate_tissue::patch::{Material, Memory, Patch};

/// Depth of the finger [m].
pub const DEPTH_M: f64 = 0.004;
/// Damping of the masses [1/s]. Its value does not matter, because the force is read at rest.
const SETTLING_PER_S: f32 = 60.0;
/// Time step of the springs [s].
const STEP_S: f64 = 1.25e-4;

/// Result of a press with the volume force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WithCoefficient {
    /// Coefficient c [Pa/m].
    pub coefficient_pa_per_m: f64,
    /// Force on the finger [N]; `None` if the press diverges.
    pub force_n: Option<f64>,
    /// Change of the tissue's volume [%]; NaN if the press diverges.
    pub volume_change_pct: f64,
}

/// Net force of a tet under (2), divided by the force on one of its corners (1): mean and largest
/// value over the tets in their rest shape, each swollen a little.
///
/// The unit vectors from the barycentre to the corners do not add up to zero unless the tet is
/// regular.
pub fn net_share(block: &Block) -> [f64; 2] {
    let mesh = &block.tissue.mesh;
    let (mut sum, mut most) = (0.0, 0.0_f64);
    for tet in &mesh.tets {
        let corners = tet.map(|n| Vector3::from(mesh.nodes_m[n as usize]));
        let barycentre = corners.iter().sum::<Vector3<f64>>() / 4.0;
        let net = corners.iter().map(|x| (x - barycentre).normalize()).sum::<Vector3<f64>>().norm();
        sum += net;
        most = most.max(net);
    }
    [sum / mesh.tets.len() as f64, most]
}

/// Presses springs of a single stiffness k [N/m] with the volume force at every coefficient.
pub fn measure(block: &Block, stiffness_n_per_m: f64, coefficients_pa_per_m: &[f64]) -> Result<Vec<WithCoefficient>, Error> {
    let any = Fitted::new(stiffness_n_per_m, 0.0);
    let mut block = StudyMethod::LocalCompression(any).block(block, STEP_S);
    block.params.node_damping_per_s = SETTLING_PER_S;
    let patch = Patch::build(&block.tissue, &Material::default(), None);
    let own = patch.wide_model();
    let springs = springs_of(&own, &block.params, stiffness_n_per_m);
    let model = Model { springs: &springs, ..own };
    let rest: Vec<Vector3<f64>> = block.tissue.mesh.nodes_m.iter().map(|x| Vector3::from(*x)).collect();
    let volume_m3 = |x: &[Vector3<f64>]| {
        let six = |t: &[u32; 4]| {
            let [a, b, c, d] = t.map(|n| x[n as usize]);
            (b - a).cross(&(c - a)).dot(&(d - a))
        };
        block.tissue.mesh.tets.iter().map(six).sum::<f64>() / 6.0
    };
    let mut found = Vec::new();
    for &coefficient in coefficients_pa_per_m {
        let mut memory = Memory::for_model(&model);
        let (tuned, state) = memory.start(&model, &block.params)?;
        let method = LocalCompression {
            dampers: None,
            volume: Some(BarycentreForce { coefficient_pa_per_m: coefficient as f32 }),
            region: None,
            step: VelocityVerlet::default(),
            compression: None,
        };
        let held = hold(&block, &mut OnCore { model: &model, tuned: &tuned, state, method }, DEPTH_M).ok();
        let volume_change_pct = held.as_ref().map_or(f64::NAN, |h| 100.0 * (volume_m3(&h.position_m) / volume_m3(&rest) - 1.0));
        found.push(WithCoefficient { coefficient_pa_per_m: coefficient, force_n: held.map(|h| h.force_n), volume_change_pct });
    }
    Ok(found)
}
