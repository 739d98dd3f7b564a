//! Annealing of k and d (section 2.2, Fig. 7), which minimises the Hausdorff distance (4)-(6)
//! between key points of the mass-spring model and those of a finite-element model.
//!
//! Key points are the free surface nodes around the site. The paper compares deformed shapes, which
//! at rest do not depend on d at all. Here shapes are therefore
//! compared *during the motion*: a finger is released with a constant force, and the objective is
//! the mean distance at four times, in millimetres; temperatures are in millimetres too. Finite
//! elements on the same mesh (neo-Hookean, nodal pressure, true masses) perform the same motion.
//! The unknowns are ln k and ln d, with random initial values. A trial that diverges at the time
//! step of the fit, or in which the finger sinks in too deep, is never accepted.

use crate::paper_method::LocalCompression;
use crate::paper_method::damper::{Dampers, DampingLaw};
use crate::paper_method::velocity_verlet::VelocityVerlet;
use palpate::Vector3;
use palpate::{Model, Params};

use super::hausdorff::hausdorff;
use super::methods::{Fitted, StudyMethod, springs_of};
use super::rest::{NoRest, Push};
use super::schedule::{Schedule, Verdict, Walk};
use crate::error::Error;
use crate::methods::{Block, Method, OnCore, RunningMethod};
use palpate_tissue::Error as TissueError;
use palpate_tissue::mesh::surface::surface;
use palpate_tissue::patch::{Material, Memory, Patch};

/// Times after the release at which key points are compared [ms].
pub const TIMES_MS: [usize; 4] = [10, 20, 40, 80];
/// Largest distance of key points from the site [finger radii].
const REACH_RADII: f64 = 2.5;
/// The paper's fitted values: k [N/m] and d, whose printed unit "Ns/m" is read as N s/m.
pub const PRINTED: [f64; 2] = [910.0, 3.11];
/// Bounds of k [N/m] and d [N s/m].
pub const BOUNDS: [[f64; 2]; 2] = [[1.0, 1e4], [1e-4, 10.0]];

/// Positions of the key points [m] at each of [`TIMES_MS`].
pub type Trajectory = Vec<Vec<Vector3<f64>>>;

/// Target of a fit: a tissue under a force, and the trajectories of the key points that the model
/// should match.
#[derive(Clone, Debug)]
pub struct Target {
    /// The tissue, with the parameters with which the model runs.
    pub block: Block,
    /// Force on the finger [N].
    pub force_n: f64,
    keys: Vec<usize>,
    truth: Trajectory,
}

/// State of a walk after its last trial at one temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Temperature [mm].
    pub temperature_mm: f64,
    /// Stiffness k of every spring [N/m].
    pub stiffness_n_per_m: f64,
    /// Damping d of every spring [N s/m].
    pub damping_n_s_per_m: f64,
    /// Objective for these values [mm].
    pub distance_mm: f64,
}

/// Result of a fit.
#[derive(Clone, Debug)]
pub struct Found {
    /// State of the walk at the end of each temperature.
    pub steps: Vec<Step>,
    /// The values with the smallest objective.
    pub best: Step,
    /// Final state of the walk.
    pub end: Step,
    /// Number of simulations, and number of those that diverged or sank.
    pub simulations: [usize; 2],
}

/// Free surface nodes near the site, which are the key points.
pub fn key_nodes(block: &Block) -> Vec<usize> {
    let site = Vector3::from(block.tissue.site_m);
    let reach_m = REACH_RADII * f64::from(block.params.probe.radius_m);
    let fixed = block.fixed();
    let near = |n: &usize| (Vector3::from(block.tissue.mesh.nodes_m[*n]) - site).norm() <= reach_m && !fixed[*n];
    let mut nodes: Vec<usize> = surface(&block.tissue.mesh.tets).into_iter().flatten().map(|n| n as usize).filter(near).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Releases a finger on tissue at rest and records the key points.
pub fn follow(block: &Block, running: &mut dyn RunningMethod, force_n: f64, keys: &[usize]) -> Result<Trajectory, NoRest> {
    let mut push = Push::new(force_n);
    running.tick(block.tip_m(push.depth_m())).map_err(|_| NoRest::Diverged { depth_mm: 0.0 })?;
    let mut trajectory = Trajectory::new();
    let mut tick = 0;
    for ms in TIMES_MS {
        let until = (ms as f64 * 1e-3 / f64::from(block.params.tick_s)).round() as usize;
        while tick < until {
            push.tick(block, running)?;
            tick += 1;
        }
        trajectory.push(keys.iter().map(|n| running.position_m(*n).cast()).collect());
    }
    Ok(trajectory)
}

/// Hausdorff distance between two motions, averaged over the times [mm].
pub fn distance_mm(a: &Trajectory, b: &Trajectory) -> f64 {
    a.iter().zip(b).map(|(a, b)| 1e3 * hausdorff(a, b)).sum::<f64>() / a.len() as f64
}

impl Target {
    /// Computes the motion with finite elements; `tick_s` is the time step of the fit.
    pub fn new(block: &Block, force_n: f64, tick_s: f64) -> Result<Self, Error> {
        let keys = key_nodes(block);
        let elements = StudyMethod::Charted(Method::NeoHookeanNodal);
        let refuse =
            |why: String| TissueError::Usage(format!("no target to fit: finite elements under {force_n} N {why}: press less"));
        let step_s = match elements.step_s(block, force_n)? {
            Some(Ok(step_s)) => step_s,
            Some(Err(why)) => return Err(Error::Tissue(refuse(why.to_string()))),
            None => return Err(Error::Tissue(refuse("cannot be had".into()))),
        };
        let own = elements.block(block, step_s.min(1e-3) / 2.0);
        let truth = elements.run(&own, |running| follow(&own, running, force_n, &keys))?;
        let truth = truth.ok_or_else(|| refuse("cannot be had".into()))?.map_err(|why| refuse(why.to_string()))?;
        let any = Fitted::new(1.0, 0.0);
        Ok(Self { block: StudyMethod::LocalCompression(any).block(block, tick_s), force_n, keys, truth })
    }

    /// Creates a simulator, which can run the model many times.
    pub fn simulator(&self) -> Simulator<'_> {
        let patch = Patch::build(&self.block.tissue, &Material::default(), None);
        let memory = Memory::for_model(&patch.wide_model());
        Simulator { target: self, patch, memory, simulations: [0; 2] }
    }
}

/// The model with its memory, which every run reuses.
pub struct Simulator<'a> {
    target: &'a Target,
    patch: Patch,
    memory: Memory,
    /// Number of runs so far, and number of those that diverged or sank.
    pub simulations: [usize; 2],
}

impl Simulator<'_> {
    /// Motion of the model with stiffness k [N/m] and damping d [N s/m]; `None` if it diverges or
    /// sinks.
    pub fn trajectory(&mut self, stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> Option<Trajectory> {
        let Target { block, force_n, keys, .. } = self.target;
        let params: &Params = &block.params;
        let own = self.patch.wide_model();
        let springs = springs_of(&own, params, stiffness_n_per_m);
        let model = Model { springs: &springs, ..own };
        let mut damping_m_s = vec![0.0; springs.len()];
        DampingLaw::Constant(damping_n_s_per_m as f32).fill(&model, params, &mut damping_m_s);
        let (tuned, state) = self.memory.start(&model, params).ok()?;
        let method = LocalCompression {
            dampers: Some(Dampers { damping_m_s: &damping_m_s }),
            volume: None,
            region: None,
            step: VelocityVerlet::default(),
            compression: None,
        };
        let trajectory = follow(block, &mut OnCore { model: &model, tuned: &tuned, state, method }, *force_n, keys).ok();
        self.simulations[0] += 1;
        self.simulations[1] += usize::from(trajectory.is_none());
        trajectory
    }

    /// Objective at (ln k, ln d) [mm]; `None` outside the bounds, or if the model diverges or
    /// sinks.
    pub fn distance_mm(&mut self, place: &[f64]) -> Option<f64> {
        let inside = place.iter().zip(BOUNDS).all(|(x, [low, high])| (low.ln()..=high.ln()).contains(x));
        let [k, d] = [0, 1].map(|n| place.get(n).map_or(f64::NAN, |x| x.exp()));
        if inside { self.trajectory(k, d).map(|trajectory| distance_mm(&trajectory, &self.target.truth)) } else { None }
    }

    /// Starts a walk at random values with which the model runs; `None` if a hundred random values
    /// fail.
    pub fn start(&mut self, schedule: Schedule, trials: usize, seed: u64) -> Option<Walk> {
        let middle = BOUNDS.map(|[low, high]| 0.5 * (low.ln() + high.ln()));
        let mut wander = Walk::start(Schedule { first: 1e300, ..schedule }, 400, seed, middle.to_vec(), 0.0);
        while !wander.is_done() {
            // at this temperature every trial within the bounds is accepted, so the end is random
            let place = wander.propose();
            let inside = place.iter().zip(BOUNDS).all(|(x, [low, high])| (low.ln()..=high.ln()).contains(x));
            let far_enough = wander.trials().0 > 60;
            if let (true, true, Some(cost)) = (far_enough, inside, self.distance_mm(&place)) {
                return Some(Walk::start(schedule, trials, seed, place, cost));
            }
            wander.judge(place, inside.then_some(0.0));
        }
        None
    }

    /// Continues a walk to its end; `saved` is called at intervals with the walk and its record.
    pub fn anneal(&mut self, mut walk: Walk, mut steps: Vec<Step>, mut saved: impl FnMut(&Walk, &[Step])) -> Found {
        let per_save = 200;
        while !walk.is_done() {
            let temperature_mm = walk.temperature();
            let there = walk.propose();
            let cost = self.distance_mm(&there);
            let verdict: Verdict = walk.judge(there, cost);
            debug_assert!(verdict == Verdict::Refused || cost.is_some());
            if walk.is_done() || walk.temperature() != temperature_mm {
                steps.push(Step::of(temperature_mm, walk.here()));
            }
            if walk.trials().0.is_multiple_of(per_save) {
                saved(&walk, &steps);
            }
        }
        saved(&walk, &steps);
        let last = steps.last().map_or(0.0, |s| s.temperature_mm);
        Found { best: Step::of(last, walk.best()), end: Step::of(last, walk.here()), steps, simulations: self.simulations }
    }
}

impl Step {
    fn of(temperature_mm: f64, (place, distance_mm): (&[f64], f64)) -> Self {
        let [k, d] = [0, 1].map(|n| place.get(n).map_or(f64::NAN, |x| x.exp()));
        Self { temperature_mm, stiffness_n_per_m: k, damping_n_s_per_m: d, distance_mm }
    }
}
