//! Runs a slide tick by tick and computes its errors relative to the reference.

use palpate::method::{Method, Product};
use palpate::stages::{force, force::foundation::Load};
use palpate::{BuildError, Fault, Model, Params, ProbePose, State, Tuned, Vector3, tick_with};
use serde::Serialize;

use super::sleeping::Sleeping;
use super::trajectory::{Leg, Pose, Trajectory};
use crate::paper_method::region::{Region, StressRule, advance_within};
use palpate_fit::calibrate::targets::Reference;
use palpate_fit::statics::Vector;
use palpate_tissue::clock::thread_time;
use palpate_tissue::patch::{Memory, Patch};

/// Nodes of a patch that move while the probe slides.
#[derive(Clone, Copy, Debug)]
pub enum Awake {
    /// All nodes: the product.
    All,
    /// Nodes that the stress rule of paper 004 (7)-(8) keeps active; the others are frozen in
    /// place.
    Stressed(StressRule),
    /// Nodes that are not at rest: [`Sleeping`] with this threshold [m].
    Moving(f64),
}

/// The product's forces and time step, applied to the nodes that the stress rule keeps active.
struct Stressed {
    rule: StressRule,
    region: Option<Region>,
}

impl Method for Stressed {
    fn begin(&mut self, tuned: &Tuned, state: &State) {
        self.region = self.rule.select(tuned, state);
    }

    fn force(&mut self, model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>, speed: Vector3<f32>) -> Load {
        let load = force::accumulate(model, tuned, state, tip_m, speed);
        self.rule.see(tuned, &load, tip_m);
        load
    }

    fn advance(&mut self, model: &Model, tuned: &Tuned, state: &mut State) -> Result<u16, Fault> {
        // symplectic Euler, as in the product
        let keep = tuned.velocity_kept();
        advance_within(self.region, model, tuned, state, |v, f, step| v * keep + f * step)
    }
}

/// One tick of a slide.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Pose of the probe.
    pub pose: Pose,
    /// Force on the probe [N].
    pub force_n: Vector,
    /// Number of nodes that were active.
    pub active_nodes: u16,
    /// CPU time of the tick [us].
    pub tick_us: f64,
}

/// Record of a slide.
#[derive(Clone, Debug)]
pub struct Slide {
    /// Trajectory that was requested.
    pub trajectory: Trajectory,
    /// One row per tick, up to the fault if there was one.
    pub rows: Vec<Row>,
    /// Fault that ended the run early.
    pub fault: Option<Fault>,
}

/// Figures of a slide over the strokes forth and back.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Figures {
    /// Speed of the probe along the surface [mm/s].
    pub speed_mm_per_s: f64,
    /// Largest error of the normal force relative to the reference, with its sign [%].
    pub worst_pct: f64,
    /// Root mean square error of the normal force [%].
    pub rms_pct: f64,
    /// Mean error of the normal force [%]; the deviation from this mean is ripple.
    pub mean_pct: f64,
    /// Largest change of the force vector between two ticks [N].
    pub step_n: f64,
    /// Largest change of the force vector between two ticks in which the number of active nodes
    /// changed [N].
    pub region_step_n: f64,
    /// Mean force along the motion relative to the normal force [%]: a negative value is drag, a
    /// positive one drives the probe on. The true value is near zero.
    pub lateral_pct: f64,
    /// Largest force along the motion, of either sign, relative to the normal force [%].
    pub lateral_worst_pct: f64,
    /// Work of the tissue on the probe over the stroke forth and back, which begins and ends at
    /// rest at the same place [mJ]: negative if energy was dissipated, positive if it was created.
    pub work_mj: f64,
    /// Smallest and mean share of the free nodes that were active [%].
    pub awake_pct: [f64; 2],
    /// Share of the free nodes that were active at the end of the hold before the first stroke [%].
    pub hold_awake_pct: f64,
    /// Median CPU time of a tick [us].
    pub tick_us: f64,
}

/// Slides a patch with the active nodes chosen by `awake`.
///
/// # Errors
/// Fails if the core rejects the model or the parameters.
pub fn slide(patch: &Patch, params: &Params, awake: Awake, trajectory: &Trajectory) -> Result<Slide, BuildError> {
    match awake {
        Awake::All => slide_with(patch, params, &mut Product, trajectory),
        Awake::Stressed(rule) => slide_with(patch, params, &mut Stressed { rule, region: None }, trajectory),
        Awake::Moving(threshold_m) => slide_with(patch, params, &mut Sleeping::new(threshold_m, &patch.model()), trajectory),
    }
}

/// Slides a patch with any method.
///
/// # Errors
/// Fails if the core rejects the model or the parameters.
pub fn slide_with(
    patch: &Patch,
    params: &Params,
    method: &mut impl Method,
    trajectory: &Trajectory,
) -> Result<Slide, BuildError> {
    let model = patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, params)?;
    let mut slide = Slide { trajectory: *trajectory, rows: Vec::new(), fault: None };
    for pose in trajectory.poses() {
        let started = thread_time();
        let output = tick_with(&model, &tuned, &mut state, ProbePose { tip_m: pose.tip_m.cast() }, method);
        let tick_us = (thread_time() - started).as_secs_f64() * 1e6;
        if output.fault.is_some() {
            slide.fault = output.fault;
            break;
        }
        slide.rows.push(Row { pose, force_n: output.force_n.cast(), active_nodes: output.active_nodes, tick_us });
    }
    Ok(slide)
}

impl Slide {
    /// Rows of the strokes forth and back.
    pub fn ways(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|r| matches!(r.pose.leg, Leg::Forth | Leg::Back))
    }

    /// Figures of the slide; `None` if it ended in a fault or the reference does not cover the
    /// path. The reference force is scaled to `youngs_modulus_pa`.
    #[must_use]
    pub fn figures(&self, reference: &impl Reference, youngs_modulus_pa: f64, free_nodes: usize) -> Option<Figures> {
        if self.fault.is_some() {
            return None;
        }
        let errors: Vec<f64> = self
            .ways()
            .map(|row| {
                let wanted_n =
                    youngs_modulus_pa * reference.force(self.trajectory.place_m(row.pose.along_m), self.trajectory.depth_m)?;
                Some(100.0 * (row.force_n.z / wanted_n - 1.0))
            })
            .collect::<Option<_>>()?;
        let ahead = |leg: Leg| if leg == Leg::Back { -self.trajectory.direction() } else { self.trajectory.direction() };
        let lateral: Vec<f64> = self.ways().map(|r| 100.0 * r.force_n.dot(&ahead(r.pose.leg)) / r.force_n.z).collect();
        let (mut step_n, mut region_step_n, mut work_j) = (0.0_f64, 0.0_f64, 0.0);
        for pair in self.rows.windows(2).filter(|p| p[1].pose.leg != Leg::Press) {
            let change_n = (pair[1].force_n - pair[0].force_n).norm();
            step_n = step_n.max(change_n);
            if pair[0].active_nodes != pair[1].active_nodes {
                region_step_n = region_step_n.max(change_n);
            }
            // a device holds each force until the next tick: the work includes the effect of that
            // delay
            work_j += pair[0].force_n.dot(&(pair[1].pose.tip_m - pair[0].pose.tip_m));
        }
        let share = |r: &Row| 100.0 * f64::from(r.active_nodes) / free_nodes as f64;
        let awake: Vec<f64> = self.ways().map(share).collect();
        let held = self.rows.iter().rfind(|r| r.pose.leg == Leg::Press);
        let mut times: Vec<f64> = self.ways().map(|r| r.tick_us).collect();
        times.sort_by(f64::total_cmp);
        Some(Figures {
            speed_mm_per_s: self.trajectory.speed_m_per_s * 1e3,
            worst_pct: largest(&errors),
            rms_pct: mean(&errors.iter().map(|e| e * e).collect::<Vec<_>>()).sqrt(),
            mean_pct: mean(&errors),
            step_n,
            region_step_n,
            lateral_pct: mean(&lateral),
            lateral_worst_pct: largest(&lateral),
            work_mj: work_j * 1e3,
            awake_pct: [awake.iter().copied().fold(f64::INFINITY, f64::min), mean(&awake)],
            hold_awake_pct: held.map_or(100.0, share),
            tick_us: times.get(times.len() / 2).copied().unwrap_or_default(),
        })
    }
}

/// The value of largest magnitude, with its sign.
pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, |most: f64, v| if v.abs() > most.abs() { v } else { most })
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_fit::calibrate::reference_map::ReferenceMap;
    use palpate_tissue::answer::Answer;

    /// A probe driven on by a force F on both strokes of length s gains 2 F s, one that is dragged
    /// loses as much; a jump of the force is found wherever it occurs.
    #[test]
    fn work_and_steps_are_those_of_the_forces() {
        let answer = Answer::block();
        let map = ReferenceMap::of(&answer).unwrap();
        let trajectory =
            Trajectory { centre_m: Vector::zeros(), stroke_m: Vector::new(0.02, 0.0, 0.0), depth_m: 0.002, speed_m_per_s: 0.05 };
        let with = |push_n: f64, jump_n: f64| {
            let row = |pose: Pose| {
                let ahead = match pose.leg {
                    Leg::Forth | Leg::Press => 1.0,
                    Leg::Back | Leg::Turn | Leg::End => -1.0,
                };
                let jump = if pose.leg == Leg::Forth && pose.along_m > 0.0 { jump_n } else { 0.0 };
                let wanted_n = 3500.0 * map.force(trajectory.place_m(pose.along_m), 0.002).unwrap();
                let force_n = Vector::new(ahead * push_n, 0.0, wanted_n + jump);
                Row { pose, force_n, active_nodes: if jump == 0.0 { 10 } else { 9 }, tick_us: 1.0 }
            };
            let slide = Slide { trajectory, rows: trajectory.poses().into_iter().map(row).collect(), fault: None };
            slide.figures(&map, 3500.0, 10).unwrap()
        };
        let pushed = with(0.01, 0.0);
        assert!((pushed.work_mj - 0.4).abs() < 0.01, "{pushed:?}");
        assert!(pushed.lateral_pct > 0.0 && pushed.worst_pct.abs() < 1e-6 && pushed.region_step_n == 0.0);
        let dragged = with(-0.01, 0.0);
        assert!((dragged.work_mj + 0.4).abs() < 0.01 && dragged.lateral_pct < 0.0, "{dragged:?}");
        let jumped = with(0.0, 0.005);
        assert!((jumped.step_n - 0.005).abs() < 1e-4 && (jumped.region_step_n - 0.005).abs() < 1e-4, "{jumped:?}");
        assert!(jumped.work_mj.abs() < 1e-9 && jumped.worst_pct > 5.0);
    }
}
