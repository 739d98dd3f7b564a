//! Sensitivity of the paper's objective to k and d, and the largest time step with which its fitted
//! values can be run.

use crate::paper_method::LocalCompression;
use crate::paper_method::damper::{Dampers, DampingLaw};
use crate::paper_method::velocity_verlet::VelocityVerlet;
use palpate::{Model, Params, ProbePose, Vector3, tick_with};

use super::fit::{Target, key_nodes};
use super::hausdorff::hausdorff;
use super::methods::{Fitted, StudyMethod, springs_of};
use super::rest::to_rest;
use super::steps::hold;
use crate::error::Error;
use crate::methods::Block;
use palpate_tissue::patch::{Material, Memory, Patch};

/// The paper's fitted values: k [N/m] and d, whose printed unit "Ns/m" is read as N s/m.
pub const PRINTED: [f64; 2] = [910.0, 3.11];
/// Depth of the held finger [m].
pub const HELD_M: f64 = 0.003;
/// Damping of the masses in presses of which only the equilibrium is used [1/s]; it does not depend
/// on the damping.
const SETTLING_PER_S: f64 = 60.0;

/// Motion of the finger, and the time at which key points are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loading {
    /// The tip is held at depth [`HELD_M`]; key points are compared at rest.
    Held,
    /// The force is constant; key points are compared at rest.
    ForceAtRest,
    /// The force is constant; key points are compared during the motion.
    ForceOnTheWay,
}

/// Change of the key points when k or d is changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Motion of the finger.
    pub drive: Loading,
    /// Hausdorff distance from the key points with the given k and d, for k/2, 2k, d/4 and 4d [mm];
    /// NaN if a press diverges or does not come to rest.
    pub moved_mm: [f64; 4],
}

/// Measures the effect of changes of k and d from fitted values, for each loading.
pub fn seen(target: &Target, stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> Result<[Seen; 3], Error> {
    let (k, d) = (stiffness_n_per_m, damping_n_s_per_m);
    let changed = [[k / 2.0, d], [2.0 * k, d], [k, d / 4.0], [k, 4.0 * d]];
    let keys = key_nodes(&target.block);
    let mut on_the_way = target.simulator();
    let mut moved = |drive: Loading| -> Result<Seen, Error> {
        let mut shape = |[k, d]: [f64; 2]| -> Result<Option<Vec<Vec<Vector3<f64>>>>, Error> {
            if drive == Loading::ForceOnTheWay {
                return Ok(on_the_way.trajectory(k, d));
            }
            let mut block = target.block.clone();
            block.params.node_damping_per_s = SETTLING_PER_S as f32;
            // half the time step, so that stiffer springs are stable too
            block.params.tick_s *= 0.5;
            let model = StudyMethod::LocalCompression(Fitted::new(k, d));
            let found = model.run(&block, |running| match drive {
                Loading::Held => hold(&block, running, HELD_M).map(|held| held.position_m).ok(),
                _ => to_rest(&block, running, target.force_n).map(|rest| rest.position_m).ok(),
            })?;
            Ok(found.flatten().map(|x| vec![keys.iter().map(|n| x[*n]).collect()]))
        };
        let here = shape([k, d])?;
        let mut moved_mm = [f64::NAN; 4];
        for (moved, place) in moved_mm.iter_mut().zip(changed) {
            if let (Some(here), Some(there)) = (&here, shape(place)?) {
                *moved = here.iter().zip(&there).map(|(a, b)| 1e3 * hausdorff(a, b)).sum::<f64>() / here.len() as f64;
            }
        }
        Ok(Seen { drive, moved_mm })
    };
    Ok([moved(Loading::Held)?, moved(Loading::ForceAtRest)?, moved(Loading::ForceOnTheWay)?])
}

/// Range of steps searched for the largest stable one [s].
const STEPS_S: [f64; 2] = [2e-8, 8e-3];
/// Number of steps without growth after which free vibration counts as stable.
const TRIAL_STEPS: usize = 1500;
/// Initial displacement of each node in such a trial [m].
const START_M: f32 = 1e-6;
/// Multiple of `START_M` beyond which the displacement of a node counts as growth (1).
const GROWN: f32 = 20.0;
/// Shortest tick of the core [s]; shorter steps are substeps of it.
const SHORTEST_TICK_S: f64 = 1e-5;

/// Largest time step [s] with which the free vibration of springs of a single stiffness k [N/m]
/// with dampers of a single d [N s/m] does not grow; found by bisection to within 3 %.
pub fn largest_step_s(block: &Block, stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> Result<f64, Error> {
    let any = Fitted::new(stiffness_n_per_m, damping_n_s_per_m);
    let block = StudyMethod::LocalCompression(any).block(block, 1e-3);
    let [mut low, mut high] = STEPS_S;
    while high / low > 1.03 {
        let middle = (low * high).sqrt();
        if vibrates(&block, &any, middle)? { low = middle } else { high = middle }
    }
    Ok(low)
}

fn vibrates(block: &Block, fitted: &Fitted, step_s: f64) -> Result<bool, Error> {
    let substeps = (SHORTEST_TICK_S / step_s).ceil().max(1.0);
    let params = Params { tick_s: (step_s * substeps) as f32, substeps: substeps as u16, ..block.params };
    let patch = Patch::build(&block.tissue, &Material::default(), None);
    let own = patch.wide_model();
    let springs = springs_of(&own, &params, fitted.stiffness_n_per_m);
    let model = Model { springs: &springs, ..own };
    let mut damping_m_s = vec![0.0; springs.len()];
    DampingLaw::Constant(fitted.damping_n_s_per_m as f32).fill(&model, &params, &mut damping_m_s);
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, &params)?;
    let rest: Vec<Vector3<f32>> = model.nodes.iter().map(|n| n.rest_m.into()).collect();
    let free = |n: usize| tuned.mass_kg(n).is_some_and(f32::is_finite);
    for (n, x) in rest.iter().enumerate().filter(|(n, _)| free(*n)) {
        // displacements whose signs alternate from node to node excite every mode
        let sign = |k: u32| if (n >> k) & 1 == 0 { START_M } else { -START_M };
        state.place(n, x + Vector3::new(sign(0), sign(1), sign(2)), Vector3::zeros());
    }
    let mut method = LocalCompression {
        dampers: Some(Dampers { damping_m_s: &damping_m_s }),
        volume: None,
        region: None,
        step: VelocityVerlet::default(),
        compression: None,
    };
    let away = ProbePose { tip_m: rest[0] + block.params.probe.axis * 10.0 };
    for _ in 0..TRIAL_STEPS.div_ceil(usize::from(params.substeps)) {
        if tick_with(&model, &tuned, &mut state, away, &mut method).fault.is_some() {
            return Ok(false);
        }
    }
    let furthest = state.nodes().iter().zip(&rest).map(|(n, x)| (n.position_m() - x).norm()).fold(0.0, f32::max);
    Ok(furthest <= GROWN * START_M)
}
