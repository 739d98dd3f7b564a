//! Time steps: the largest stable one with each form of the damper (12), and the force of a press
//! as a function of the time step when lengths are corrected.

use crate::paper_method::VolumePreserved;
use crate::paper_method::damper::DampingLaw;
use crate::paper_method::length::SpringLength;
use palpate::{Params, ProbePose, Terms, Vector3, tick_with};

use super::assembly::Assembly;
use super::method::{HangingMethod, Setup, printed, stepped};
use crate::error::Error;
use crate::methods::Block;
use palpate_tissue::Error as TissueError;
use palpate_tissue::patch::{Material, Memory, Patch};
use palpate_tissue::scene;

/// Length of the tick [s].
const TICK_S: f32 = scene::TICK_S as f32;
/// Share of the largest stable step that runs use (1).
const MARGIN: f32 = 0.8;
/// Number of steps without divergence after which a time step counts as stable.
const TRIAL_STEPS: usize = 3000;
/// Acceleration with which the organs are pushed in a trial [m/s^2].
const PUSH_M_PER_S2: f32 = 0.1;
/// Ratio of successive time steps that are tried (1), and the longest and the shortest of them [s].
const RATIO: f32 = 1.122;
const LONGEST_S: f32 = 8e-3;
const SHORTEST_S: f32 = 1e-9;

/// Largest stable time steps, and forces of a press as a function of the time step.
#[derive(Clone, Debug)]
pub struct Steps {
    /// Form of the damper, and largest stable step with it at the sparse resolution [s].
    pub stable: Vec<(&'static str, f32)>,
    /// Share of critical damping (1), and largest stable step with it [s]: any damper along the
    /// springs shortens the step.
    pub damped: Vec<(f64, f64)>,
    /// Time step [s], and force of a press 2 mm deep on a block [N]: with (6)-(8) at tau = 0, at
    /// tau = 0.1, and with compensation as an energy.
    pub force: [Vec<(f64, f64)>; 3],
}

/// Forms among [`LAWS`] that follow the printed (12): with a wrong unit, or with the sum of the
/// masses.
pub const PRINTED_LAWS: [&str; 3] = ["2 sqrt(k (m1+m2)), without l0", "(12), l0 in mm", "(12) as printed, l0 in m"];

/// Forms of the damper and their names in tables.
pub const LAWS: [(&str, DampingLaw); 6] = [
    ("none", DampingLaw::Critical(0.0)),
    ("0.1 of critical", DampingLaw::Critical(0.1)),
    ("critical, 2 sqrt(k m1 m2/(m1+m2))", DampingLaw::Critical(1.0)),
    ("2 sqrt(k (m1+m2)), without l0", DampingLaw::WithoutLength),
    ("(12), l0 in mm", DampingLaw::PrintedMillimetres),
    ("(12) as printed, l0 in m", DampingLaw::PrintedMetres),
];

/// Setup with the time step that a method uses: the product takes two steps per tick, the printed
/// methods 0.8 of their largest stable step, but at most a tick.
pub fn working_setup(method: HangingMethod, assembly: &Assembly, longest_s: f64) -> Result<Setup, Error> {
    Ok(match method {
        HangingMethod::Palpate => Setup { method, dt_s: 0.5 * TICK_S, substeps: Some(2), longest_s },
        HangingMethod::VolumePreserved { .. } => {
            let dt_s = (MARGIN * largest_step_s(method, assembly)?).min(TICK_S);
            Setup { method, dt_s, substeps: None, longest_s }
        }
    })
}

/// Largest time step with which the organs sway under a light push without divergence [s].
pub fn largest_step_s(method: HangingMethod, assembly: &Assembly) -> Result<f32, Error> {
    let network = method.network(assembly);
    let model = network.patch.wide_model();
    // near rest the limit is that of the linear system: an upper bound, which is close for springs
    // in tension but not for springs in compression
    let survives = |dt_s: f32| -> Result<bool, Error> {
        // a light push excites every mode and leaves springs near their rest lengths
        let params = Params { gravity_m_per_s2: [PUSH_M_PER_S2; 3], ..stepped(&network.params, dt_s, None) };
        let mut memory = Memory::for_model(&model);
        let (tuned, mut state) = memory.start(&model, &params)?;
        let mut constants = vec![0.0; model.springs.len()];
        if let HangingMethod::VolumePreserved { damping, .. } = method {
            damping.fill(&model, &params, &mut constants);
        }
        let mut before_m: Vec<[f32; 3]> = model.nodes.iter().map(|n| n.rest_m).collect();
        let Some(mut printed) = printed(method, &constants, &mut before_m) else { return Ok(true) };
        let away = ProbePose { tip_m: Vector3::new(0.0, 0.0, 10.0) };
        let ticks = TRIAL_STEPS / usize::from(params.substeps);
        let fault = (0..ticks).find_map(|_| tick_with(&model, &tuned, &mut state, away, &mut printed).fault);
        let fastest = state.nodes().iter().map(|n| n.velocity_m_per_s().norm()).fold(0.0, f32::max);
        // no node can become faster than in a free fall of that duration
        let fall_m_per_s = PUSH_M_PER_S2 * dt_s * TRIAL_STEPS as f32;
        Ok(fault.is_none() && fastest < 2.0 * fall_m_per_s)
    };
    let mut dt_s = LONGEST_S;
    while dt_s > SHORTEST_S && !survives(dt_s)? {
        dt_s /= RATIO;
    }
    Ok(dt_s)
}

impl Steps {
    /// Measures stable steps and forces; `quick` takes fewer dampings and fewer time steps.
    pub fn measure(sparse: &Assembly, quick: bool) -> Result<Self, Error> {
        let mut stable = Vec::new();
        for (name, damping) in LAWS {
            stable.push((name, largest_step_s(HangingMethod::VolumePreserved { rates: None, damping }, sparse)?));
        }
        let shares: &[f32] = if quick { &[0.01, 0.1, 1.0, 10.0] } else { &[0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0] };
        let damped = shares.iter().map(|share| {
            let method = HangingMethod::VolumePreserved { rates: None, damping: DampingLaw::Critical(*share) };
            Ok((f64::from(*share), f64::from(largest_step_s(method, sparse)?)))
        });
        let damped = damped.collect::<Result<Vec<_>, Error>>()?;
        let substeps: &[u16] = if quick { &[2, 8, 32] } else { &[2, 4, 8, 16, 32, 64, 128] };
        let force = [Some(0.0), Some(0.1), None].map(|tau| {
            let at = |n: &u16| press_force_n(*n, tau).map(|force_n| (1e-3 / f64::from(*n), force_n));
            substeps.iter().map(at).collect::<Result<Vec<_>, _>>()
        });
        let [zero, tenth, energy] = force;
        Ok(Self { stable, damped, force: [zero?, tenth?, energy?] })
    }
}

/// Force of a press 2 mm deep on the standard block of 130 nodes [N], with lengths corrected to
/// within `tau`; with `None` compensation is an energy instead.
fn press_force_n(substeps: u16, tau: Option<f32>) -> Result<f64, Error> {
    const DEPTH_M: f64 = 2e-3;
    let block = Block::standard(130, 3500.0)?;
    let mut params = block.params;
    params.substeps = substeps;
    params.node_damping_per_s = 60.0;
    let poisson_ratio = if tau.is_some() { 0.25 } else { f64::from(params.poisson_ratio) };
    params.poisson_ratio = poisson_ratio as f32;
    if tau.is_some() {
        params.terms = Terms::SPRINGS_ONLY;
        params.mass_floor = 0.0;
    }
    let patch = Patch::build(&block.tissue, &Material { poisson_ratio, ..Material::default() }, None);
    let model = patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, &params)?;
    let length = tau.map(|tau| SpringLength { stretch: tau, compression: tau });
    let mut method = VolumePreserved { length, ..VolumePreserved::default() };
    let mut force_n = 0.0;
    for n in 0..900 {
        let depth_m = (f64::from(n) * 2e-5 - 1e-3).min(DEPTH_M);
        let pose = ProbePose { tip_m: block.tip_m(depth_m) };
        let output = tick_with(&model, &tuned, &mut state, pose, &mut method);
        if let Some(fault) = output.fault {
            return Err(TissueError::Check(format!("press with {substeps} steps a tick: {fault:?}")).into());
        }
        force_n = f64::from(output.force_n.norm());
    }
    Ok(force_n)
}
