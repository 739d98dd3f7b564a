//! A tap: a press to a depth, a hold and a release. It checks that the patch withstands the tap and
//! returns to rest.

use palpate::stages::probe::ProbePose;
use palpate::{Params, Vector3, tick};
use palpate_tissue::measure;

use crate::bench::{Bench, Noise};

/// Largest displacement allowed after release [m].
const RESIDUAL_M: f64 = 0.05e-3;
/// Largest ripple of the force in a hold, as a share of that force (1).
const RIPPLE: f32 = 0.01;
/// Largest speed of a node allowed at the end of the hold [m/s]. The ripple of the force is not a
/// sufficient criterion, because a force at its limit shows none.
const STILL_M_PER_S: f32 = 5e-3;
/// Height at which the probe starts above the surface [m].
const CLEAR_M: f64 = 0.5e-3;
/// Duration of the hold, and time to come to rest after the release [s].
const HOLD_S: f64 = 0.35;
const REST_S: f64 = 0.6;
/// Number of ticks evaluated at the end of the hold and at the end of the run.
const LAST: usize = 50;

/// Motion of the probe into the tissue and out again.
#[derive(Clone, Copy, Debug)]
pub struct Tap {
    /// Depth of the hold [m].
    pub deep_m: f64,
    /// Speed in both directions [m/s].
    pub speed_m_per_s: f64,
    /// Jitter of the time at which a pose is taken, as a share of a tick (1).
    pub jitter: f64,
}

/// Outcome of a tap.
#[derive(Debug)]
pub struct Outcome {
    /// Defect at the end of the hold or of the run, or the fault that ended the run early.
    pub wrong: Option<String>,
    /// Smallest ratio of a tet's volume to its rest volume in any tick (1).
    pub lowest_j: f64,
    /// Smallest ratio of a tet's volume to its rest volume at the end of the hold (1).
    pub held_j: f64,
    /// Largest force [N].
    pub peak_n: f64,
    /// Force at the end of the hold [N].
    pub static_n: f64,
    /// Largest displacement of a node after the release [m].
    pub residual_m: f64,
}

impl Tap {
    /// Moves the probe in, holds it for 0.35 s, moves it out and waits for 0.6 s.
    ///
    /// # Panics
    /// Panics if the core refuses the parameters.
    pub fn run(&self, bench: &Bench, params: &Params) -> Outcome {
        let mut outcome = Outcome {
            wrong: None,
            lowest_j: f64::INFINITY,
            held_j: f64::INFINITY,
            peak_n: 0.0,
            static_n: 0.0,
            residual_m: f64::INFINITY,
        };
        outcome.wrong = self.observe(bench, params, &mut outcome);
        outcome
    }

    /// Depth at a time [m]; the probe turns back at `held_s`.
    fn depth_m(&self, time_s: f64, held_s: f64) -> f64 {
        let displacement_m = |time_s: f64| self.speed_m_per_s * time_s.max(0.0);
        let down_m = (displacement_m(time_s) - CLEAR_M).min(self.deep_m);
        if time_s < held_s { down_m } else { (self.deep_m - displacement_m(time_s - held_s)).max(-CLEAR_M) }
    }

    fn observe(&self, bench: &Bench, params: &Params, outcome: &mut Outcome) -> Option<String> {
        let model = bench.patch.wide_model();
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, params).expect("parameters that the core takes");
        let tick_s = f64::from(params.tick_s);
        let way_s = (self.deep_m + CLEAR_M) / self.speed_m_per_s;
        let ticks = |seconds: f64| (seconds / tick_s).ceil() as usize;
        let held = ticks(way_s) + ticks(HOLD_S);
        let all = held + ticks(way_s) + ticks(REST_S);
        let mut noise = Noise::new(7);
        let mut holds: Vec<Vector3<f32>> = Vec::new();
        for n in 0..all {
            let late = self.jitter * noise.uniform();
            let depth_m = self.depth_m((n as f64 + late) * tick_s, held as f64 * tick_s);
            let tip_m = bench.patch.site_m() - params.probe.axis * depth_m as f32;
            let output = tick(&model, &tuned, &mut state, ProbePose { tip_m });
            if let Some(fault) = output.fault {
                return Some(format!("{fault} in tick {n}"));
            }
            let (lowest_j, _) = measure::volumes(&model, &state);
            outcome.lowest_j = outcome.lowest_j.min(lowest_j);
            outcome.peak_n = outcome.peak_n.max(output.force_n.norm().into());
            let at_hold = (held - LAST..held - 1).contains(&n);
            if at_hold {
                holds.push(output.force_n);
                outcome.held_j = lowest_j;
                let fastest = state.nodes().iter().map(|n| n.velocity_m_per_s().norm()).fold(0.0, f32::max);
                if fastest > STILL_M_PER_S {
                    return Some(format!("nodes move at {fastest:.3} m/s at the hold's end, in tick {n}"));
                }
            }
            if lowest_j <= 0.0 && (at_hold || n + LAST >= all) {
                return Some(format!("J = {lowest_j:.3} at rest, in tick {n}"));
            }
        }
        let mean = holds.iter().sum::<Vector3<f32>>() / holds.len() as f32;
        outcome.static_n = mean.norm().into();
        let ripple = holds.iter().map(|f| (f - mean).norm()).fold(0.0, f32::max) / mean.norm();
        if ripple > RIPPLE {
            return Some(format!("the force at the hold's end ripples by {:.1} %", ripple * 100.0));
        }
        outcome.residual_m = measure::largest_displacement_m(&model, &state);
        (outcome.residual_m > RESIDUAL_M).then(|| format!("{:.3} mm are left", outcome.residual_m * 1e3))
    }
}
