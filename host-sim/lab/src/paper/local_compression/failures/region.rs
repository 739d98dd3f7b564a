//! The dynamic region (7)-(8): its radius, the share of nodes that it keeps awake, and the force
//! error that freezing the others causes.

use crate::paper_method::LocalCompression;
use crate::paper_method::region::{ContactPressure, StressRule};
use crate::paper_method::velocity_verlet::VelocityVerlet;
use palpate::{Fault, Model, ProbePose, State, Tuned, Vector3, tick_with};

use super::super::methods::{Fitted, StudyMethod, springs_of};
use super::super::steps::hold;
use crate::error::Error;
use crate::methods::{Block, RunningMethod};
use palpate_tissue::patch::{Material, Memory, Patch};

/// Depth of the finger [m].
pub const DEPTH_M: f64 = 0.004;
/// Damping of the masses [1/s]: the force is read at rest.
const SETTLING_PER_S: f32 = 60.0;
/// Step of the springs [s].
const STEP_S: f64 = 1.25e-4;

/// Region of a held press, and its force error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Awake {
    /// Form of equation (8).
    pub pressure: ContactPressure,
    /// Smallest vertical stress down to which nodes stay awake [Pa].
    pub least_stress_pa: f64,
    /// Radius of the region [m].
    pub radius_m: f64,
    /// Share of the free nodes that are awake (1).
    pub share: f64,
    /// Relative error of the force against that with all nodes awake (1).
    pub force_error: f64,
}

/// A running method that records the number of awake nodes.
struct Counting<'a> {
    model: &'a Model<'a>,
    tuned: &'a Tuned<'a>,
    state: State<'a>,
    method: LocalCompression<'a>,
    active: u16,
}

impl RunningMethod for Counting<'_> {
    fn tick(&mut self, tip_m: Vector3<f32>) -> Result<Vector3<f32>, Fault> {
        let output = tick_with(self.model, self.tuned, &mut self.state, ProbePose { tip_m }, &mut self.method);
        self.active = output.active_nodes;
        output.fault.map_or(Ok(output.force_n), Err)
    }

    fn position_m(&self, node: usize) -> Vector3<f32> {
        self.state.nodes()[node].position_m()
    }
}

/// Presses springs of a single stiffness k [N/m] with both forms of (8) at every threshold; a press
/// that diverges is left out.
pub fn measure(block: &Block, stiffness_n_per_m: f64, least_stresses_pa: &[f64]) -> Result<Vec<Awake>, Error> {
    let any = Fitted::new(stiffness_n_per_m, 0.0);
    let mut block = StudyMethod::LocalCompression(any).block(block, STEP_S);
    block.params.node_damping_per_s = SETTLING_PER_S;
    let patch = Patch::build(&block.tissue, &Material::default(), None);
    let own = patch.wide_model();
    let springs = springs_of(&own, &block.params, stiffness_n_per_m);
    let model = Model { springs: &springs, ..own };
    let free = (model.nodes.len() - model.anchors.len()) as f64;
    let press = |region: Option<StressRule>| -> Result<Option<(f64, f64)>, Error> {
        let mut memory = Memory::for_model(&model);
        let (tuned, state) = memory.start(&model, &block.params)?;
        let method = LocalCompression { dampers: None, volume: None, region, step: VelocityVerlet::default(), compression: None };
        let mut running = Counting { model: &model, tuned: &tuned, state, method, active: 0 };
        let held = hold(&block, &mut running, DEPTH_M).ok();
        Ok(held.map(|held| (held.force_n, f64::from(running.active) / free)))
    };
    let Some((all_n, _)) = press(None)? else { return Ok(Vec::new()) };
    let mut found = Vec::new();
    for pressure in [ContactPressure::UniformLoad, ContactPressure::RigidPunch] {
        for &least_stress_pa in least_stresses_pa {
            let rule = StressRule::new(least_stress_pa as f32, block.params.poisson_ratio, pressure);
            let Some((force_n, share)) = press(Some(rule))? else { continue };
            let contact_pa = rule.pressure_pa(block.params.youngs_modulus_pa, force_n as f32, DEPTH_M as f32);
            let radius_m = f64::from(rule.radius_m(contact_pa, block.params.probe.radius_m));
            found.push(Awake { pressure, least_stress_pa, radius_m, share, force_error: force_n / all_n - 1.0 });
        }
    }
    Ok(found)
}

/// The region with the smallest share of awake nodes, under one form of (8), whose force error is
/// at most `most_error` (1).
pub fn least_awake(found: &[Awake], pressure: ContactPressure, most_error: f64) -> Option<Awake> {
    let good = found.iter().filter(|a| a.pressure == pressure && a.force_error.abs() <= most_error);
    good.min_by(|a, b| a.share.total_cmp(&b.share)).copied()
}
