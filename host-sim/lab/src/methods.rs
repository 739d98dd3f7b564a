//! Published methods and ours on the same task, each in one file and behind one trait. None of the
//! others is part of the core.
//!
//! All of them press the same block on the same meshes, in single precision, with rest data
//! computed beforehand and without allocation in a tick. The explicit ones run *on* the core, which
//! provides the guard, the contact (with the foundation points and the law of the product), the
//! integrator, the node damping, and the mass floor `m >= f E D T^2` computed from their own rest
//! stiffness; their file contains only the internal force. The two that solve a linear system
//! (implicit, compliance) treat contact as such methods do: unilateral, at the nodes, without
//! friction.

mod block;
mod compliance;
mod corotational;
mod factor;
mod implicit;
mod law;
mod linear;
mod meshless;
mod moving_least_squares;
mod neo_hookean;
mod node_contact;
mod on_core;
mod papers;
mod rest_tet;
mod xpbd;

pub use block::{BLOCK_M, Block, DEEPEST_M, Fitted, RADIUS_M, Size};
pub use compliance::Compliance;
pub use corotational::Corotational;
pub use factor::Factor;
pub use implicit::Implicit;
pub use law::law;
pub use linear::LinearElastic;
pub use meshless::Meshless;
pub use moving_least_squares::{ShapeFunctions, Share, integration_points_m};
pub use neo_hookean::{NeoHookean, Volume};
pub use on_core::{Law, OnCore};
pub use rest_tet::RestTet;
pub use xpbd::Xpbd;

use serde::{Deserialize, Serialize};

use palpate::method::Product;
use palpate::{ClampFlags, Fault, Model, Params, Spring, Terms, Vector3};

use palpate_tissue::error::Error;
use palpate_tissue::moving::with_substeps;
use palpate_tissue::patch::{Material, Memory, Patch};

/// A method that runs on one block.
pub trait RunningMethod {
    /// Runs one millisecond, at the end of which the tip is at `tip_m` [m]. Returns the force on
    /// the probe [N], which points out of the tissue.
    fn tick(&mut self, tip_m: Vector3<f32>) -> Result<Vector3<f32>, Fault>;

    /// Position of a node [m].
    fn position_m(&self, node: usize) -> Vector3<f32>;

    /// Inputs that a guard in front of the method clamped in the last tick; no flag is set if there
    /// is no guard.
    fn limiters(&self) -> ClampFlags {
        ClampFlags::DEFAULT
    }

    /// Whether the method has a surface that deforms.
    fn has_surface(&self) -> bool {
        true
    }

    /// Floating-point operations of the solver in the last tick; 0 for methods without a solver.
    fn solver_flops(&self) -> f64 {
        0.0
    }
}

/// Every method of the chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Method {
    /// Springs of paper 000, eq 11 as printed, with masses and contact.
    Springs,
    /// Paper 000: springs with corrections of length and direction.
    VolumePreserved,
    /// Paper 004: springs of one stiffness with an over-compression correction.
    LocalCompression,
    /// Springs and per-tet volume energy.
    SpringsVolumeTet,
    /// Springs and nodal-averaged volume energy.
    SpringsVolumeNodal,
    /// Springs, volume and compression compensation: the product without calibration.
    Palpate,
    /// The product with a calibrated patch.
    Calibrated,
    /// The product's law, which has no nodes.
    Law,
    /// Linear tets, each in its own rotating frame.
    Corotational,
    /// Total-Lagrangian neo-Hookean tets.
    NeoHookean,
    /// Total-Lagrangian neo-Hookean tets with the volume term averaged over nodes, which does not
    /// lock.
    NeoHookeanNodal,
    /// Neo-Hookean energy on moving-least-squares shape functions, integrated in background cells.
    Meshless,
    /// Extended position-based dynamics.
    Xpbd,
    /// Implicit Euler with corotational forces and a matrix that is factored once, at rest.
    Implicit,
    /// Precomputed compliance of linear elasticity.
    Compliance,
}

impl Method {
    /// All methods in the order of legends and tables.
    pub const ALL: [Self; 15] = [
        Self::Springs,
        Self::VolumePreserved,
        Self::LocalCompression,
        Self::SpringsVolumeTet,
        Self::SpringsVolumeNodal,
        Self::Palpate,
        Self::Calibrated,
        Self::Law,
        Self::Corotational,
        Self::NeoHookean,
        Self::NeoHookeanNodal,
        Self::Meshless,
        Self::Xpbd,
        Self::Implicit,
        Self::Compliance,
    ];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Springs => "springs",
            Self::VolumePreserved => "volume-preserved",
            Self::LocalCompression => "local-compression",
            Self::SpringsVolumeTet => "springs-volume-tet",
            Self::SpringsVolumeNodal => "springs-volume-nodal",
            Self::Palpate => "palpate",
            Self::Calibrated => "palpate-calibrated",
            Self::Law => "palpate-law",
            Self::Corotational => "corotational",
            Self::NeoHookean => "neo-hookean",
            Self::NeoHookeanNodal => "neo-hookean-nodal",
            Self::Meshless => "meshless",
            Self::Xpbd => "xpbd",
            Self::Implicit => "implicit",
            Self::Compliance => "compliance",
        }
    }

    /// The method called `name` in files.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|m| m.name() == name)
    }

    /// Whether the method is the product's, with all or some of its terms.
    pub fn is_ours(self) -> bool {
        matches!(
            self,
            Self::Springs | Self::SpringsVolumeTet | Self::SpringsVolumeNodal | Self::Palpate | Self::Calibrated | Self::Law
        )
    }

    /// Whether more substeps can improve the method.
    pub fn takes_substeps(self) -> bool {
        !matches!(self, Self::Compliance | Self::Law)
    }

    /// Builds the method for a block and passes it to `work`; each of its `substeps` is split by
    /// the block's refinement. `None` if the method is not available, because no calibrated patch
    /// of this size exists.
    pub fn run<T>(
        self,
        block: &Block,
        substeps: u16,
        work: impl FnOnce(&mut dyn RunningMethod) -> T,
    ) -> Result<Option<T>, Error> {
        let split = |params: &Params| with_substeps(&Params { substeps, ..*params }, block.refinement);
        let params = split(&block.params);
        let patch = |share: f64| {
            let material = Material { per_tet_share: share, ..Material::default() };
            Patch::build(&block.tissue, &material, None)
        };
        let usual = Material::default().per_tet_share;
        let without = Terms { compensation: false, ..Terms::ALL };
        let answer = match self {
            Self::Springs => springs_alone(&patch(usual), &params, work)?,
            Self::VolumePreserved => papers::volume_preserved(&patch(usual), &params, work)?,
            Self::LocalCompression => {
                let even = Patch::build(&block.even_tissue(), &Material::default(), None);
                papers::local_compression(&patch(usual), &even, &params, work)?
            }
            Self::SpringsVolumeTet => own(&patch(1.0), &Params { terms: without, ..params }, work)?,
            Self::SpringsVolumeNodal => own(&patch(0.0), &Params { terms: without, ..params }, work)?,
            Self::Palpate => own(&patch(usual), &params, work)?,
            Self::Calibrated => match calibrated(block) {
                Some((patch, fitted)) => own(&patch, &split(&fitted), work)?,
                None => return Ok(None),
            },
            Self::Law => law::with(block, &Params { substeps: 1, ..block.params }, work)?,
            Self::Corotational => on_core::with_law(block, &params, Corotational::new(block), work)?,
            Self::NeoHookean => on_core::with_law(block, &params, NeoHookean::new(block, Volume::PerTet), work)?,
            Self::NeoHookeanNodal => on_core::with_law(block, &params, NeoHookean::new(block, Volume::Nodal), work)?,
            Self::Meshless => on_core::with_law(block, &params, Meshless::new(block)?, work)?,
            Self::Xpbd => xpbd::with(&patch(1.0), &params, work)?,
            Self::Implicit => work(&mut Implicit::new(block, &params)?),
            Self::Compliance => work(&mut Compliance::new(block)?),
        };
        Ok(Some(answer))
    }
}

/// The patch that was fitted to the block or, with as many nodes, to the standard one, and the
/// parameters fitted with it; `None` if there is none.
pub fn calibrated(block: &Block) -> Option<(Patch, Params)> {
    let (mut patch, packed) = match &block.fitted.patch {
        Some(own) => own.clone(),
        None => {
            let (patch, packed) = palpate_tissue::session::calibrated::sized(block.size().nodes)?;
            (patch.with_inclusions(&block.inclusions), packed)
        }
    };
    patch.set_depth_limit_m(block.tissue.depth_limit_m as f32);
    let Params { compensation, compensation_threshold, mass_floor, .. } = packed;
    let contact_damping = block.contact_damping.unwrap_or(packed.contact_damping);
    Some((patch, Params { compensation, compensation_threshold, mass_floor, contact_damping, ..block.params }))
}

fn own<T>(patch: &Patch, params: &Params, work: impl FnOnce(&mut dyn RunningMethod) -> T) -> Result<T, Error> {
    on_core_alone(&patch.wide_model(), params, work)
}

/// Runs the plain model of the papers.
fn springs_alone<T>(patch: &Patch, params: &Params, work: impl FnOnce(&mut dyn RunningMethod) -> T) -> Result<T, Error> {
    let model = patch.wide_model();
    let springs = printed_springs(&model, params);
    let params = Params { terms: Terms::SPRINGS_ONLY, ..*params };
    on_core_alone(&Model { springs: &springs, ..model }, &params, work)
}

/// Springs (11) as printed. The model's springs contain our factor `1/(0.8 (1 + nu))`, with which
/// they carry the shear alone; it is removed here.
fn printed_springs(model: &Model, params: &Params) -> Vec<Spring> {
    let factor = 0.8 * (1.0 + params.poisson_ratio);
    model.springs.iter().map(|s| Spring { k: s.k * factor, k_rest: s.k_rest * factor, ..*s }).collect()
}

fn on_core_alone<T>(model: &Model, params: &Params, work: impl FnOnce(&mut dyn RunningMethod) -> T) -> Result<T, Error> {
    let mut memory = Memory::for_model(model);
    let (tuned, state) = memory.start(model, params)?;
    Ok(work(&mut OnCore { model, tuned: &tuned, state, method: Product }))
}
