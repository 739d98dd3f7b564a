//! The methods with which the hanging organs are simulated, all on the core's tick.

use crate::paper_method::VolumePreserved;
use crate::paper_method::damper::{Dampers, DampingLaw};
use crate::paper_method::direction::SpringDirection;
use crate::paper_method::length::SpringLength;
use palpate::method::{Method, Product};
use palpate::stages::probe::ProbePose;
use palpate::{Fault, Model, Params, State, Terms, Tuned, Vector3, tick_with};

use super::assembly::Assembly;
use super::measured::Measured;
use super::network::{Joints, Network};
use crate::error::Error;
use palpate_tissue::patch::{Material, Memory};

/// Critical angle of (9) in the paper's experiments [rad]: pi/3.
pub const ANGLE_RAD: f32 = std::f32::consts::FRAC_PI_3;
/// Number of steps between two checks of (9) in the paper's experiments.
pub const LOOK_EVERY: u16 = 100;
/// Distance at which the probe is kept, so that it touches nothing [m].
const AWAY_M: f32 = 10.0;
/// Speed of the stick [m/s].
const LIFT_M_PER_S: f64 = 0.1;
/// Largest displacement of a node per 0.1 s at which the organs count as at rest [m], and number of
/// ticks over which displacements are measured.
const REST_M: f32 = 4e-6;
const REST_TICKS: usize = 100;

/// A method of the comparison, with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HangingMethod {
    /// The product: springs, volume and compensation.
    Palpate,
    /// The method of paper 000.
    VolumePreserved {
        /// Critical stretching and compressing rates `tau_s` and `tau_c` (1); `None` leaves out
        /// (6)-(8).
        rates: Option<[f32; 2]>,
        /// Law of the dampers, in place of (12).
        damping: DampingLaw,
    },
}

/// A method with its time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// Method with its settings.
    pub method: HangingMethod,
    /// Time step [s].
    pub dt_s: f32,
    /// Number of steps per tick for a method whose mass floor depends on the tick; `None` takes as
    /// many as fill the core's shortest tick.
    pub substeps: Option<u16>,
    /// Virtual time after which a move ends even without rest [s].
    pub longest_s: f64,
}

/// Final state after a move.
#[derive(Clone, Debug)]
pub struct Rest {
    /// Measured deformation at the end of the move.
    pub measured: Measured,
    /// Number of steps since the previous move.
    pub steps: usize,
    /// Whether the organs came to rest within `longest_s`.
    pub at_rest: bool,
    /// CPU time of the move [s].
    pub cpu_s: f64,
}

impl HangingMethod {
    /// Name in tables.
    pub fn name(self) -> String {
        match self {
            Self::Palpate => "palpate".into(),
            Self::VolumePreserved { rates, damping } => {
                let rates = rates.map_or("no length correction".into(), |[s, c]| format!("tau {s}/{c}"));
                let damping = match damping {
                    DampingLaw::PrintedMetres => "(12) as printed".into(),
                    DampingLaw::PrintedMillimetres => "(12), l0 in mm".into(),
                    DampingLaw::WithoutLength => "(12) without l0".into(),
                    DampingLaw::Critical(share) => format!("{share} critical"),
                    DampingLaw::Constant(d) => format!("d = {d} N s/m"),
                };
                format!("volume-preserved, {rates}, damping {damping}")
            }
        }
    }

    /// The organs as a spring network of this method.
    pub fn network(self, assembly: &Assembly) -> Network {
        match self {
            Self::Palpate => {
                let poisson_ratio = assembly.scene.poisson_ratio;
                let material = Material { poisson_ratio, per_tet_share: per_tet_share(poisson_ratio), ..Material::default() };
                let mut network = Network::build(assembly, &material, Joints::Triangle);
                network.params.node_damping_per_s = 8.0;
                network
            }
            Self::VolumePreserved { .. } => {
                let mut network =
                    Network::build(assembly, &Material { poisson_ratio: 0.25, ..Material::default() }, Joints::Nearest);
                network.params =
                    Params { terms: Terms::SPRINGS_ONLY, mass_floor: 0.0, node_damping_per_s: 0.0, ..network.params };
                network
            }
        }
    }
}

/// Share of the volume stiffness that acts per tet (1). It must be of the order of the shear
/// modulus to suppress alternating modes; a larger share would lock.
fn per_tet_share(poisson_ratio: f64) -> f64 {
    let kappa = |nu: f64| nu / ((1.0 + nu) * (1.0 - 2.0 * nu)) - 0.5 / (1.0 + nu);
    let default = Material::default();
    default.per_tet_share * kappa(default.poisson_ratio) / kappa(poisson_ratio)
}

/// Simulates the scene with a method; returns one result for each move, up to the first fault.
/// `progress` is called with (move, virtual time [s]).
pub fn hang(assembly: &Assembly, setup: &Setup, progress: impl FnMut(usize, f64)) -> Result<Vec<Result<Rest, Fault>>, Error> {
    hang_network(assembly, &setup.method.network(assembly), setup, progress)
}

/// Simulates the scene like [`hang`], with a given network instead of the method's own.
pub fn hang_network(
    assembly: &Assembly,
    network: &Network,
    setup: &Setup,
    mut progress: impl FnMut(usize, f64),
) -> Result<Vec<Result<Rest, Fault>>, Error> {
    let model = network.patch.wide_model();
    let params = stepped(&network.params, setup.dt_s, setup.substeps);
    let mut memory = Memory::for_model(&model);
    let (tuned, state) = memory.start(&model, &params)?;
    let mut run = Run { model: &model, tuned: &tuned, state, network, params: &params, at_m: Vector3::zeros() };
    let mut results = Vec::new();
    let damping_m_s = match setup.method {
        HangingMethod::Palpate => Vec::new(),
        HangingMethod::VolumePreserved { damping, .. } => {
            let mut constants = vec![0.0; model.springs.len()];
            damping.fill(&model, &params, &mut constants);
            constants
        }
    };
    let mut before_m: Vec<[f32; 3]> = model.nodes.iter().map(|n| n.rest_m).collect();
    let mut printed = printed(setup.method, &damping_m_s, &mut before_m);
    for (n, to) in assembly.scene.attachment.moves_m.iter().enumerate() {
        let to = Vector3::from(*to);
        let rest = match &mut printed {
            None => run.go(assembly, to, setup.longest_s, &mut Product, |t| progress(n, t)),
            Some(method) => run.go(assembly, to, setup.longest_s, method, |t| progress(n, t)),
        };
        let over = rest.is_err();
        results.push(rest);
        if over {
            break;
        }
    }
    Ok(results)
}

/// Parameters with steps of `dt_s` and `substeps` of them per tick; without `substeps` the smallest
/// number for which the core accepts the tick.
pub fn stepped(params: &Params, dt_s: f32, substeps: Option<u16>) -> Params {
    const SHORTEST_TICK_S: f32 = 1e-5;
    let fewest = (SHORTEST_TICK_S / dt_s).ceil().clamp(1.0, 1000.0) as u16;
    let substeps = substeps.unwrap_or(fewest);
    Params { tick_s: dt_s * f32::from(substeps), substeps, ..*params }
}

/// The stages of paper 000 that a method needs; `None` for the product.
pub fn printed<'a>(method: HangingMethod, damping_m_s: &'a [f32], before_m: &'a mut [[f32; 3]]) -> Option<VolumePreserved<'a>> {
    let HangingMethod::VolumePreserved { rates, .. } = method else { return None };
    Some(VolumePreserved {
        dampers: Some(Dampers { damping_m_s }),
        length: rates.map(|[stretch, compression]| SpringLength { stretch, compression }),
        direction: Some(SpringDirection { angle_rad: ANGLE_RAD, every: LOOK_EVERY, before_m, age: 0 }),
        ..VolumePreserved::default()
    })
}

struct Run<'a> {
    model: &'a Model<'a>,
    tuned: &'a Tuned<'a>,
    state: State<'a>,
    network: &'a Network,
    params: &'a Params,
    /// Displacement of the stick from rest [m].
    at_m: Vector3<f64>,
}

impl Run<'_> {
    /// Moves the stick in a straight line to the displacement `to` in equal increments (paper 000,
    /// "attachment"), then waits for rest.
    fn go(
        &mut self,
        assembly: &Assembly,
        to: Vector3<f64>,
        longest_s: f64,
        method: &mut impl Method,
        mut progress: impl FnMut(f64),
    ) -> Result<Rest, Fault> {
        let started = palpate_tissue::clock::thread_time().as_secs_f64();
        let (from, tick_s) = (self.at_m, f64::from(self.params.tick_s));
        let iterations = ((to - from).norm() / (LIFT_M_PER_S * tick_s)).ceil().max(1.0) as usize;
        let most = iterations + (longest_s / tick_s) as usize;
        let mut before: Vec<Vector3<f32>> = self.state.nodes().iter().map(|n| n.position_m()).collect();
        let (mut ticks, mut at_rest) = (0, false);
        while ticks < most && !at_rest {
            ticks += 1;
            let share = ticks.min(iterations) as f64 / iterations as f64;
            let speed = if ticks <= iterations { (to - from) / (iterations as f64 * tick_s) } else { Vector3::zeros() };
            self.at_m = from + (to - from) * share;
            for (n, rest_m) in &self.network.held {
                self.state.place(*n, (rest_m + self.at_m).cast(), speed.cast());
            }
            let away = ProbePose { tip_m: Vector3::new(0.0, 0.0, AWAY_M) };
            let output = tick_with(self.model, self.tuned, &mut self.state, away, method);
            if let Some(fault) = output.fault {
                return Err(fault);
            }
            if ticks % REST_TICKS == 0 {
                let mut furthest = 0.0_f32;
                for (before, node) in before.iter_mut().zip(self.state.nodes()) {
                    let now = node.position_m();
                    furthest = furthest.max((now - *before).norm());
                    *before = now;
                }
                // the criterion is a speed, so it is equally strict at every time step
                let allowed = REST_M * (REST_TICKS as f32 * self.params.tick_s) / 0.1;
                at_rest = ticks > iterations + REST_TICKS && furthest <= allowed;
                progress(ticks as f64 * tick_s);
            }
        }
        let corners: Vec<Vector3<f64>> = self
            .state
            .nodes()
            .iter()
            .zip(self.model.nodes)
            .map(|(n, r)| n.position_m().cast() - Vector3::from(r.rest_m).cast())
            .collect();
        Ok(Rest {
            measured: Measured::of_corners(assembly, &corners),
            steps: ticks * usize::from(self.params.substeps),
            at_rest,
            cpu_s: palpate_tissue::clock::thread_time().as_secs_f64() - started,
        })
    }
}
