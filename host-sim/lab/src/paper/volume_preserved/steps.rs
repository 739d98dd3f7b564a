//! Time step of each method: for the printed ones, a share of the largest stable one.

use palpate::{Params, ProbePose, Vector3, tick_with};

use super::assembly::Assembly;
use super::method::{HangingMethod, Setup, printed, stepped};
use crate::error::Error;
use palpate_tissue::patch::Memory;
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
