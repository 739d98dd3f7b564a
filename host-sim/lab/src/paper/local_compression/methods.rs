//! The methods that Figs. 8 and 9 compare, each with its own time step and damping.
//!
//! | method | force | step |
//! |---|---|---|
//! | `local-compression` | springs of one k (1), no volume, region (7)-(8) | Verlet (9)-(10) |
//! | `springs` | springs of paper 000, eq (11) | symplectic Euler |
//! | `meshless`, `neo-hookean-nodal` | moving least squares; finite elements | symplectic Euler |
//! | `palpate`, `palpate-calibrated` | the product | symplectic Euler, 1 ms |
//!
//! Masses are those of (10) in paper 000; the product's also have its mass floor. All methods damp
//! the masses by 40/s, except `local-compression` with "d alone"; `local-compression` also has the
//! damper d of each spring (1).
//!
//! The contact with the finger is the core's in all of them. The time step of a method is the
//! largest of 1, 1/2, 1/4 .. ms with which it comes to rest under the largest force that it
//! survives.

use crate::paper_method::LocalCompression;
use crate::paper_method::damper::{Dampers, DampingLaw};
use crate::paper_method::region::StressRule;
use crate::paper_method::velocity_verlet::VelocityVerlet;
use palpate::{Model, Params, Spring, Terms};

use super::rest::{AtRest, NoRest, to_rest};
use crate::error::Error;
use crate::methods::{Block, Method, OnCore, RunningMethod};
use palpate_tissue::patch::{Material, Memory, Patch};

/// Largest number of times that the time step of a millisecond is halved.
const MOST_HALVINGS: u32 = 6;

/// The constants that the paper fits, and its region.
#[derive(Clone, Copy, Debug)]
pub struct Fitted {
    /// Stiffness of every spring, k [N/m].
    pub stiffness_n_per_m: f64,
    /// Damping of every spring, d [N s/m].
    pub damping_n_s_per_m: f64,
    /// Damping of the masses [1/s]; the paper has none.
    pub node_damping_per_s: f64,
    /// Stress rule of the region; `None` keeps all nodes awake.
    pub region: Option<StressRule>,
}

impl Fitted {
    /// Constants k [N/m] and d [N s/m], without mass damping or region.
    pub fn new(stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> Self {
        Self { stiffness_n_per_m, damping_n_s_per_m, node_damping_per_s: 0.0, region: None }
    }
}

/// A method of the comparison.
#[derive(Clone, Copy, Debug)]
pub enum StudyMethod {
    /// The paper's method.
    LocalCompression(Fitted),
    /// A method that the chart also has.
    Charted(Method),
}

impl StudyMethod {
    /// Name in tables.
    pub fn name(&self) -> &'static str {
        match self {
            Self::LocalCompression(fitted) if fitted.node_damping_per_s > 0.0 => "local-compression",
            Self::LocalCompression(_) => "local-compression, d alone",
            Self::Charted(method) => method.name(),
        }
    }

    /// Whether the masses are floored, so that the time step can be a millisecond.
    fn is_floored(&self) -> bool {
        matches!(self, Self::Charted(Method::Palpate | Method::Calibrated))
    }

    /// The tissue with the parameters with which this method runs.
    pub fn block(&self, block: &Block, tick_s: f64) -> Block {
        let mut block = block.clone();
        block.params.tick_s = tick_s as f32;
        if !self.is_floored() {
            block.params = Params { mass_floor: 0.0, ..block.params };
        }
        if let Self::LocalCompression(fitted) = self {
            let node_damping_per_s = fitted.node_damping_per_s as f32;
            block.params = Params { terms: Terms::SPRINGS_ONLY, node_damping_per_s, ..block.params };
        }
        block
    }

    /// Builds the method for a tissue from [`Self::block`] and passes it to `work`. `None` if the
    /// method is not available, because no calibrated patch of this mesh exists.
    pub fn run<T>(&self, block: &Block, work: impl FnOnce(&mut dyn RunningMethod) -> T) -> Result<Option<T>, Error> {
        match self {
            Self::LocalCompression(fitted) => run_fitted(block, fitted, work).map(Some),
            Self::Charted(method) => Ok(method.run(block, 1, work)?),
        }
    }

    /// Largest time step with which the method comes to rest under a force [s], or the reason why
    /// it does not come to rest with any step tried. `None` if it is not available.
    pub fn step_s(&self, block: &Block, force_n: f64) -> Result<Option<Result<f64, NoRest>>, Error> {
        let mut why = None;
        for halvings in 0..=if self.is_floored() { 0 } else { MOST_HALVINGS } {
            let tick_s = 1e-3 / f64::from(1 << halvings);
            let block = self.block(block, tick_s);
            match self.run(&block, |running| to_rest(&block, running, force_n))? {
                None => return Ok(None),
                Some(Ok(_)) => return Ok(Some(Ok(tick_s))),
                // a shorter time step does not damp more
                Some(Err(restless @ NoRest::Restless { .. })) => return Ok(Some(Err(restless))),
                Some(Err(failure)) => why = Some(failure),
            }
        }
        Ok(why.map(Err))
    }

    /// Presses from rest until nothing moves, `runs` times, and returns the press with the least
    /// CPU time. `None` if it is not available.
    pub fn press(&self, block: &Block, tick_s: f64, force_n: f64, runs: usize) -> Result<Option<Result<AtRest, NoRest>>, Error> {
        let block = self.block(block, tick_s);
        let mut best: Option<AtRest> = None;
        for _ in 0..runs.max(1) {
            match self.run(&block, |running| to_rest(&block, running, force_n))? {
                None => return Ok(None),
                Some(Err(failure)) => return Ok(Some(Err(failure))),
                Some(Ok(rest)) if best.as_ref().is_none_or(|b| rest.cpu_s < b.cpu_s) => best = Some(rest),
                Some(Ok(_)) => {}
            }
        }
        Ok(best.map(Ok))
    }
}

/// The springs of a model with their stiffness replaced by a single one [N/m].
pub fn springs_of(model: &Model, params: &Params, stiffness_n_per_m: f64) -> Vec<Spring> {
    let k = (stiffness_n_per_m / f64::from(params.youngs_modulus_pa)) as f32;
    model.springs.iter().map(|s| Spring { k, k_rest: k * (s.k_rest / s.k), ..*s }).collect()
}

fn run_fitted<T>(block: &Block, fitted: &Fitted, work: impl FnOnce(&mut dyn RunningMethod) -> T) -> Result<T, Error> {
    let patch = Patch::build(&block.tissue, &Material::default(), None);
    let own = patch.wide_model();
    let springs = springs_of(&own, &block.params, fitted.stiffness_n_per_m);
    let model = Model { springs: &springs, ..own };
    let mut damping_m_s = vec![0.0; springs.len()];
    DampingLaw::Constant(fitted.damping_n_s_per_m as f32).fill(&model, &block.params, &mut damping_m_s);
    let mut memory = Memory::for_model(&model);
    let (tuned, state) = memory.start(&model, &block.params)?;
    let method = LocalCompression {
        dampers: Some(Dampers { damping_m_s: &damping_m_s }),
        volume: None,
        region: fitted.region,
        step: VelocityVerlet::default(),
        compression: None,
    };
    Ok(work(&mut OnCore { model: &model, tuned: &tuned, state, method }))
}
