//! Blocks of tissue under a ball that is moved tick by tick, for comparison with closed forms.

use palpate::stages::probe::ProbePose;
use palpate::{Model, Output, Params, ProbeShape, State, Tuned, Vector3};
use palpate_tissue::Error as TissueError;
use palpate_tissue::mesh::{BlockSpec, block};
use palpate_tissue::patch::{Material, Memory, Patch};
use palpate_tissue::session::calibrated;
use palpate_tissue::stable_step::limits;
use palpate_tissue::tissue::Tissue;

use crate::Error;

/// Sides of the large block [m]: ten times the width of a contact, so that it acts as a half-space.
const BLOCK_M: [f64; 3] = [0.16, 0.16, 0.08];
/// Nodes of the large block, and the radius around the site within which they are densest [m].
const NODES: usize = 5000;
const FINE_RADIUS_M: f64 = 8e-3;
/// Radius of the ball on the large block [m]: a contact radius then spans four to eight elements.
pub(super) const RADIUS_M: f64 = 16e-3;
/// Young's modulus [Pa], high enough that a press that lasts a second excites no waves; both closed
/// forms are valid for any modulus.
const YOUNGS_MODULUS_PA: f32 = 20e3;
/// Depth limit of the large block [m].
const DEPTH_LIMIT_M: f64 = 5e-3;

/// A patch under a probe, with its parameters.
pub(super) struct Bench {
    /// Patch that is pressed.
    pub patch: Patch,
    /// Parameters of the patch.
    pub params: Params,
}

impl Bench {
    /// A large block under a large ball, with stiffnesses from the formulas alone: no calibrated
    /// patch of this size exists.
    pub fn large() -> Result<Self, Error> {
        let spec = BlockSpec { size_m: BLOCK_M, nodes: NODES, fine_at_m: [0.0; 2], fine_radius_m: FINE_RADIUS_M };
        let mesh = block(&spec).map_err(|cause| TissueError::Check(format!("the large block cannot be meshed: {cause}")))?;
        let on_bottom = |x: &[f64; 3]| x[2] < -BLOCK_M[2] * (1.0 - 1e-9);
        let anchors = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| on_bottom(x)).map(|(n, _)| n).collect();
        let stiffness_ratio = vec![1.0; mesh.tets.len()];
        let tissue = Tissue::closed(mesh, stiffness_ratio, anchors, [0.0; 3], DEPTH_LIMIT_M);
        let patch = Patch::build(&tissue, &Material::default(), None);
        let mut params = Params { youngs_modulus_pa: YOUNGS_MODULUS_PA, ..Params::default() };
        params.probe.radius_m = RADIUS_M as f32;
        params.limits = limits(&patch, f64::from(params.tick_s));
        Ok(Self { patch, params })
    }

    /// A shipped patch under the hemisphere of its own probe, or under a flat end of the same
    /// radius.
    pub fn shipped(nodes: usize, shape: ProbeShape) -> Result<Self, Error> {
        let missing = || TissueError::Check(format!("no patch of {nodes} nodes ships"));
        let (patch, packed) = calibrated::sized(nodes).ok_or_else(missing)?;
        let mut params = Params { limits: limits(&patch, f64::from(packed.tick_s)), substeps: 1, ..packed };
        params.probe.shape = shape;
        Ok(Self { patch, params })
    }
}

/// A running patch.
pub(super) struct Run<'a> {
    model: &'a Model<'a>,
    tuned: Tuned<'a>,
    state: State<'a>,
}

impl<'a> Run<'a> {
    /// Starts the patch at rest, with the probe a millimetre above it.
    pub fn start(model: &'a Model<'a>, params: &Params, memory: &'a mut Memory) -> Result<Self, Error> {
        let (tuned, state) = memory.start(model, params)?;
        let mut run = Self { model, tuned, state };
        run.at([0.0; 2], -1e-3)?;
        Ok(run)
    }

    /// Runs one tick with the tip at `place_m`, `depth_m` below the surface at rest.
    pub fn at(&mut self, place_m: [f64; 2], depth_m: f64) -> Result<Output, Error> {
        let tip_m = Vector3::new(place_m[0], place_m[1], -depth_m).cast();
        let output = palpate::tick(self.model, &self.tuned, &mut self.state, ProbePose { tip_m });
        match output.fault {
            None => Ok(output),
            Some(fault) => Err(TissueError::Check(format!("the block under the ball: {fault}")).into()),
        }
    }

    /// Replaces the parameters of the running patch and returns the previous ones: a drag with
    /// friction follows a press without friction.
    pub fn retune(&mut self, tuned: Tuned<'a>) -> Tuned<'a> {
        core::mem::replace(&mut self.tuned, tuned)
    }
}
