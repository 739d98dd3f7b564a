//! A slide in the tick, and its figures relative to the reference.

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
    /// Nodes that the stress rule of paper 004 (7)-(8) keeps; the rest are frozen in place.
    Stressed(StressRule),
    /// Nodes that do not rest: [`Sleeping`] with this threshold [m].
    Moving(f64),
}

/// The product's forces and step on the nodes that the stress rule keeps.
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
        // symplectic Euler, as the product
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
    /// Nodes that moved.
    pub active_nodes: u16,
    /// CPU time [us].
    pub tick_us: f64,
}

/// A slide, tick by tick.
#[derive(Clone, Debug)]
pub struct Slide {
    /// The requested trajectory.
    pub trajectory: Trajectory,
    /// Every tick, up to the fault if there was one.
    pub rows: Vec<Row>,
    /// Fault that ended the run early.
    pub fault: Option<Fault>,
}

/// A slide in numbers, over the strokes forth and back.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Figures {
    /// Speed [mm/s].
    pub speed_mm_per_s: f64,
    /// Normal force against the reference: the largest error, with its sign [%].
    pub worst_pct: f64,
    /// Root mean square error of the normal force [%].
    pub rms_pct: f64,
    /// Mean of the error [%]; the remainder is ripple.
    pub mean_pct: f64,
    /// Largest change of the force vector between two ticks [N].
    pub step_n: f64,
    /// Largest change of the force vector between two ticks where the set of nodes that move
    /// changed [N].
    pub region_step_n: f64,
    /// Mean force along the path over the normal force [%]: below zero it drags, above zero it
    /// pushes the probe on. The true value is near zero.
    pub lateral_pct: f64,
    /// Largest force along the path, of either sign, over the normal force [%].
    pub lateral_worst_pct: f64,
    /// Work of the tissue on the probe from rest forth and back to rest in the same place [mJ]:
    /// below zero it was lost, above zero it was created.
    pub work_mj: f64,
    /// Least and mean share of the free nodes that moved [%].
    pub awake_pct: [f64; 2],
    /// Share of the free nodes that moved after a hold, before the first stroke [%].
    pub hold_awake_pct: f64,
    /// Median CPU time of a tick [us].
    pub tick_us: f64,
}

/// Slides a patch.
///
/// # Errors
/// Model or parameters that the core rejects.
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
/// Model or parameters that the core rejects.
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

    /// The slide in numbers; `None` if it ended in a fault or the reference does not cover the
    /// path. Forces are at `youngs_modulus_pa`.
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
            // a device holds each force until the next: the effect of the tick's delay is included
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

/// The entry of largest size, with its sign.
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

    /// A probe that is pushed on both strokes gains 2 F s, one that is dragged loses it; a jump of
    /// the force is found wherever it is.
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
