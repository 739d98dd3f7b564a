//! A method on a block, with the substeps that it needs.

use serde::{Deserialize, Serialize};

use palpate::method::Product;
use palpate::{ClampFlags, Fault, Model, Params, ProbePose, State, Tuned, Vector3, tick_with};

use super::load_case::{CaseTissue, INCLUSION, Stimulus};
use super::press::{Trace, press};
use super::verdict::{Figures, judge};
use crate::chart::{MOST_SUBSTEPS, least_substeps};
use crate::error::Error;
use crate::methods::{BLOCK_M, Block, DEEPEST_M, Method, RunningMethod, calibrated};
use palpate_loop::closed_loop::fidelity;
use palpate_tissue::Error as TissueError;
use palpate_tissue::budget::MACHINES;
use palpate_tissue::patch::{Material, Memory, Patch};
use palpate_tissue::session::Session;
use palpate_tissue::stable_step::{limits, with_tick};
use palpate_tissue::tissue::DEPTH_MARGIN;

/// Depth of the taps from which the substeps for a loop are derived [m].
const FIDELITY_DEPTH_M: f64 = 4e-3;
/// Depth limit of methods without a guard [m], at the bottom of the block.
const NO_LIMIT_M: f64 = BLOCK_M[2];

/// Configuration of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Build {
    /// The method with the substeps that it needs; the product with the derived ones and its guard.
    Derived,
    /// The product without its guard, to test the model alone.
    Unguarded,
}

/// A row of the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Row {
    /// Method of the chart.
    pub method: Method,
    /// Configuration of the method.
    pub build: Build,
}

/// All rows: the product first, then its parts, then the other methods in the order of the chart.
pub const ROWS: [Row; 16] = [
    row(Method::Palpate, Build::Derived),
    row(Method::Calibrated, Build::Derived),
    row(Method::Law, Build::Derived),
    row(Method::Palpate, Build::Unguarded),
    row(Method::SpringsVolumeNodal, Build::Derived),
    row(Method::SpringsVolumeTet, Build::Derived),
    row(Method::Springs, Build::Derived),
    row(Method::VolumePreserved, Build::Derived),
    row(Method::LocalCompression, Build::Derived),
    row(Method::Corotational, Build::Derived),
    row(Method::NeoHookean, Build::Derived),
    row(Method::NeoHookeanNodal, Build::Derived),
    row(Method::Meshless, Build::Derived),
    row(Method::Xpbd, Build::Derived),
    row(Method::Implicit, Build::Derived),
    row(Method::Compliance, Build::Derived),
];

const fn row(method: Method, build: Build) -> Row {
    Row { method, build }
}

impl Row {
    /// Name in files and pictures.
    pub fn name(&self) -> String {
        let words = match self.build {
            Build::Derived => "",
            Build::Unguarded => " no guard",
        };
        format!("{}{words}", self.method.name())
    }

    /// Whether the product makes promises for this row.
    pub fn is_promised(&self) -> bool {
        self.is_product() && self.build == Build::Derived
    }

    fn is_product(&self) -> bool {
        matches!(self.method, Method::Palpate | Method::Calibrated)
    }
}

/// A row on one tissue.
#[derive(Clone, Debug)]
pub struct BuiltMethod {
    /// Row of the matrix to which the method belongs.
    pub row: Row,
    /// Tissue and parameters except the substeps.
    pub block: Block,
    /// Substeps per tick.
    pub substeps: u16,
    /// Patch of the product with its guard; `None` for other rows.
    guarded: Option<Patch>,
}

impl BuiltMethod {
    /// Sets up a row on the standard block, with the addition of `tissue`. `None` if the method is
    /// not available, lacks the term that the tissue needs, or refuses the tissue.
    pub fn new(row: Row, nodes: usize, youngs_modulus_pa: f64, tissue: CaseTissue) -> Result<Option<Self>, Error> {
        if tissue.needs_a_term() && !row.is_product() {
            return Ok(None);
        }
        let block = match row.method {
            Method::Calibrated => match Block::calibrated(nodes, youngs_modulus_pa) {
                Some(block) => block,
                None => return Ok(None),
            },
            _ => Block::standard(nodes, youngs_modulus_pa)?,
        };
        let inclusion = tissue == CaseTissue::Inclusion;
        let mut block = if inclusion { block.with_inclusion(INCLUSION) } else { block };
        block.params = tissue.of(block.params);
        if !row.is_product() {
            block.tissue.depth_limit_m = NO_LIMIT_M;
            let substeps = match least_substeps(row.method, &block)? {
                None => return Ok(None),
                Some(Ok(survival)) => survival.substeps,
                Some(Err(_)) => MOST_SUBSTEPS,
            };
            return Ok(Some(Self { row, block, substeps, guarded: None }));
        }
        block.tissue.depth_limit_m = DEPTH_MARGIN * DEEPEST_M;
        let Some((patch, params)) = product(&block, row.method) else { return Ok(None) };
        let params = Params { substeps: 1, limits: limits(&patch, f64::from(params.tick_s)), ..params };
        let params = if tissue == CaseTissue::Stiffening {
            // as in the command `press`, exponents that exceed the bound at the depth limit are
            // refused
            match Session::of_fitted(&MACHINES[0], patch.clone(), params) {
                Ok(session) => session.params,
                Err(TissueError::TooSlow(_)) => return Ok(None),
                Err(cause) => return Err(cause.into()),
            }
        } else {
            fidelity::derive(&patch, &params, FIDELITY_DEPTH_M)?.params
        };
        let substeps = params.substeps;
        if row.build == Build::Unguarded {
            block.tissue.depth_limit_m = NO_LIMIT_M;
            return Ok(Some(Self { row, block, substeps, guarded: None }));
        }
        block.params = params;
        Ok(Some(Self { row, block, substeps, guarded: Some(patch) }))
    }

    /// Returns the method with a tick of `tick_s`, and with masses and foundation unchanged.
    pub fn with_tick(&self, tick_s: f32) -> Self {
        let params = with_tick(&self.block.params, tick_s);
        Self { block: Block { params, ..self.block.clone() }, ..self.clone() }
    }

    /// Returns the method with another Young's modulus [Pa] and the same substeps.
    pub fn with_modulus(&self, youngs_modulus_pa: f64) -> Self {
        let params = Params { youngs_modulus_pa: youngs_modulus_pa as f32, ..self.block.params };
        Self { block: Block { params, ..self.block.clone() }, ..self.clone() }
    }

    /// Runs a stimulus and classifies the result.
    pub fn stand(&self, stimulus: &Stimulus) -> Result<Figures, Error> {
        Ok(judge(&self.press(stimulus)?, stimulus.is_slow()))
    }

    /// Runs a stimulus and records it.
    pub fn press(&self, stimulus: &Stimulus) -> Result<Trace, Error> {
        let Some(patch) = &self.guarded else {
            let trace = self.row.method.run(&self.block, self.substeps, |running| press(&self.block, running, stimulus))?;
            return Ok(trace.ok_or_else(|| TissueError::Usage(format!("{} cannot be had", self.row.name())))?);
        };
        let model = patch.wide_model();
        let mut memory = Memory::for_model(&model);
        let (tuned, state) = memory.start(&model, &Params { substeps: self.substeps, ..self.block.params })?;
        let mut guarded = Guarded { model: &model, tuned: &tuned, state, limiters: ClampFlags::DEFAULT };
        Ok(press(&self.block, &mut guarded, stimulus))
    }
}

/// Patch and parameters of the product on a block; `None` if no calibrated patch exists.
fn product(block: &Block, method: Method) -> Option<(Patch, Params)> {
    if method == Method::Calibrated {
        return calibrated(block);
    }
    Some((Patch::build(&block.tissue, &Material::default(), None), block.params))
}

/// The product behind its guard.
struct Guarded<'a> {
    model: &'a Model<'a>,
    tuned: &'a Tuned<'a>,
    state: State<'a>,
    limiters: ClampFlags,
}

impl RunningMethod for Guarded<'_> {
    fn tick(&mut self, tip_m: Vector3<f32>) -> Result<Vector3<f32>, Fault> {
        let output = tick_with(self.model, self.tuned, &mut self.state, ProbePose { tip_m }, &mut Product);
        self.limiters = output.limiters;
        output.fault.map_or(Ok(output.force_n), Err)
    }

    fn position_m(&self, node: usize) -> Vector3<f32> {
        self.state.nodes()[node].position_m()
    }

    fn limiters(&self) -> ClampFlags {
        self.limiters
    }
}
