//! Chooses the substeps for a moving probe: the smallest number that keeps the moving error within
//! the scene's limit.
//!
//! The search starts from the number of substeps with which the patch is stable. It then tries
//! shorter substeps, with which floored masses are lighter, until the force is accurate enough in
//! the worst of the motions that the scene's drive can make.

use palpate::Params;
use serde::Serialize;

use super::Session;
use crate::budget::{Cost, CostModel, triangles_in_reach};
use crate::error::Error;
use crate::moving::{Approach, CourseError, Ramp, SelfCheck, TRUTHS, Trajectory, Worst, with_substeps};
use crate::scene::{Drive, Scene, TICK_S};
use crate::stable_step::{StableStep, substeps_for_taps};
use crate::tissue::DEPTH_MARGIN;

/// Limit of the moving error if the scene gives none [%].
pub const DEFAULT_ERROR_PCT: f64 = 5.0;
/// Lowest speed at which a patch is checked [m/s]: no hand palpates more slowly, and at this speed
/// floored masses are hardly felt.
const LEAST_SPEED_M_PER_S: f64 = 0.02;
/// Lowest speed at which a patch for a board is checked [m/s]: any hand may be on it.
const BOARD_M_PER_S: f64 = 0.2;
/// Multiples of the stable number of substeps that are tried.
const TRIED: [u16; 5] = [1, 2, 3, 4, 6];

/// Moving error at the speed of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MovingReport {
    /// Largest speed of the motions that were tried [m/s].
    pub speed_m_per_s: f64,
    /// Motion with the largest error.
    pub motion: &'static str,
    /// Root mean square of that error over the motion and the 20 ms after it, relative to the
    /// largest force [%]: the deviation from the same patch with much shorter substeps or, if that
    /// is larger, from the stored finite elements of the scene.
    pub rms_pct: f64,
    /// Largest error that is aimed at [%].
    pub allowed_pct: f64,
    /// Whether the scene asks for that limit. It limits the deviation from the same patch alone:
    /// substeps do not change the error of the mesh.
    pub asked: bool,
    /// Whether that deviation is within the limit.
    pub within: bool,
}

/// A multiple of the substeps that was tried, and its result.
struct Tried {
    times: u16,
    substeps: u16,
    worst: Worst,
    cost: Cost,
}

impl Tried {
    /// The report, with the errors against the stored finite elements of the scene.
    fn report(&self, scene: &Scene, approach: Approach, truths: Option<Worst>) -> MovingReport {
        let Approach { speed_m_per_s, .. } = approach;
        let Worst { rms_pct, motion } = truths.map_or(self.worst, |truths| self.worst.or(truths));
        let (asked, allowed_pct) = (scene.solver.moving_error_pct.is_some(), allowed_pct(scene));
        let within = self.worst.rms_pct <= allowed_pct;
        MovingReport { speed_m_per_s, motion, rms_pct, allowed_pct, asked, within }
    }
}

impl MovingReport {
    /// Whether the error is within the limit that the scene asks for, if it does.
    #[must_use]
    pub fn keeps(&self) -> bool {
        !self.asked || self.within
    }
}

/// Moving error that a scene allows [%].
fn allowed_pct(scene: &Scene) -> f64 {
    scene.solver.moving_error_pct.unwrap_or(DEFAULT_ERROR_PCT)
}

impl Session {
    /// Chooses the smallest number of substeps within the machine's budget with which a ramp at the
    /// scene's speed stays within the limit of the moving error. If the scene gives no limit and
    /// the default cannot be met, the number with the smallest error is used, and
    /// [`super::Report::moving`] records the error.
    ///
    /// # Errors
    /// The limit that the scene gives cannot be met; the message says how many substeps or nodes
    /// would meet it.
    pub fn for_motion(self, machine: &CostModel, scene: &Scene) -> Result<Self, Error> {
        let unjudged = |session: Self| match scene.solver.moving_error_pct {
            None => Ok(session),
            Some(pct) => Err(Error::TooSlow(format!(
                "{}: solver.moving_error_pct = {pct} cannot be judged: the patch does not survive the scene's ramp within the budget: move more slowly, press less deep, or leave the key out",
                scene.file
            ))),
        };
        let Some((approach, tried)) = self.tried(machine, scene)? else { return unjudged(self) };
        let allowed_pct = allowed_pct(scene);
        let within = tried.iter().filter(|t| t.cost.units <= t.cost.budget);
        let Some(best) = within.min_by(|a, b| a.worst.rms_pct.total_cmp(&b.worst.rms_pct)) else { return unjudged(self) };
        if best.worst.rms_pct > allowed_pct && scene.solver.moving_error_pct.is_some() {
            return Err(self.cannot_keep(scene, approach, best, &tried));
        }
        let truths = self.off_truths(scene, &with_substeps(&self.params, best.times), approach)?;
        let (times, report) = (best.times, best.report(scene, approach, truths));
        self.with_motion(approach, times, report)
    }

    /// Chooses the substeps with the smallest error among those with which `accepts` the session.
    ///
    /// # Errors
    /// Fails if the core rejects the model.
    pub fn for_motion_as(
        self,
        machine: &CostModel,
        scene: &Scene,
        accepts: impl Fn(&Self) -> bool,
    ) -> Result<Option<Self>, Error> {
        let Some((approach, mut tried)) = self.tried(machine, scene)? else { return Ok(accepts(&self).then_some(self)) };
        tried.sort_by(|a, b| a.worst.rms_pct.total_cmp(&b.worst.rms_pct));
        for one in tried {
            let truths = self.off_truths(scene, &with_substeps(&self.params, one.times), approach)?;
            let judged = self.clone().with_motion(approach, one.times, one.report(scene, approach, truths))?;
            if accepts(&judged) {
                return Ok(Some(judged));
            }
        }
        Ok(None)
    }

    fn with_motion(mut self, approach: Approach, times: u16, report: MovingReport) -> Result<Self, Error> {
        self.params = with_substeps(&self.params, times);
        if times > 1 {
            let measured = StableStep::measure(&self.patch.wide_model(), &self.params, approach.site_m)?;
            self.stable = measured.unwrap_or(self.stable);
            self.report = super::report(&self.patch, &self.params, &self.stable, self.report.flipped_tets)?;
        }
        self.report.moving = Some(report);
        Ok(self)
    }

    /// Tries multiples of the substeps in rising order, up to the first that meets the limit.
    /// `None` if there is no approach, or no reference to compare with.
    fn tried(&self, machine: &CostModel, scene: &Scene) -> Result<Option<(Approach, Vec<Tried>)>, Error> {
        let Some(approach) = self.approach(machine, scene) else { return Ok(None) };
        let allowed_pct = allowed_pct(scene);
        let Some(check) = SelfCheck::of(&self.patch, &self.params, approach)? else { return Ok(None) };
        let mut tried: Vec<Tried> = Vec::new();
        for times in TRIED {
            let Some(one) = self.try_substeps(machine, &check, times)? else { continue };
            let keeps = one.worst.rms_pct <= allowed_pct;
            let too_slow = one.cost.units > one.cost.budget;
            tried.push(one);
            // beyond the budget the search continues only if the scene gives a limit, to report
            // what would meet it
            if keeps || too_slow && scene.solver.moving_error_pct.is_none() {
                break;
            }
        }
        Ok(Some((approach, tried)))
    }

    /// The approach at the speed of the scene's ramp, or at the largest inward speed of a trace; on
    /// a board at 200 mm/s at least. `None` if the deepest hold is not below the surface.
    fn approach(&self, machine: &CostModel, scene: &Scene) -> Option<Approach> {
        let axis = self.params.probe.axis;
        let along = |pair: &[[f32; 3]]| {
            let [from, to] = [0, 1].map(|n| palpate::Vector3::from(pair[n]).dot(&axis));
            f64::from(from - to) / TICK_S
        };
        let recorded = self.tips_m.windows(2).map(along).fold(0.0, f64::max);
        let speed_m_per_s = scene.drive.ramp_m_per_s().unwrap_or(recorded);
        let limit_m = f64::from(self.patch.model().depth_limit_m);
        let depth_m = match &scene.drive {
            Drive::Depth { holds_m, .. } => holds_m.iter().copied().fold(0.0, f64::max).min(limit_m),
            Drive::Hand { .. } | Drive::Force { .. } | Drive::Trace { .. } => limit_m / DEPTH_MARGIN,
        };
        let speed_m_per_s = speed_m_per_s.max(if machine.is_board() { BOARD_M_PER_S } else { LEAST_SPEED_M_PER_S });
        let free = machine.is_board() || !matches!(scene.drive, Drive::Depth { .. });
        (depth_m > 0.0).then_some(Approach { site_m: self.patch.site_m(), speed_m_per_s, depth_m, free })
    }

    /// Tries a multiple of the substeps. `None` if the patch is not stable with it or does not
    /// survive a motion.
    fn try_substeps(&self, machine: &CostModel, check: &SelfCheck, times: u16) -> Result<Option<Tried>, Error> {
        let params = with_substeps(&self.params, times);
        let (model, site_m) = (self.patch.wide_model(), self.patch.site_m());
        if times > 1 {
            let stable = StableStep::measure(&model, &params, site_m)?;
            if stable.is_none_or(|s| s.substeps(TICK_S) > f64::from(params.substeps))
                || substeps_for_taps(&model, &params, site_m, params.substeps)? != Some(params.substeps)
            {
                return Ok(None);
            }
        }
        let Some(worst) = check.worst(&self.patch, &params)? else { return Ok(None) };
        let touched = triangles_in_reach(&model, site_m.into(), params.probe.reach_m());
        let cost = machine.cost_with(&model, &params, touched, params.substeps);
        Ok(Some(Tried { times, substeps: params.substeps, worst, cost }))
    }

    /// Largest error against the stored finite elements of the scene, in the motions that its drive
    /// can make; `None` if none is stored.
    fn off_truths(&self, scene: &Scene, params: &Params, approach: Approach) -> Result<Option<Worst>, Error> {
        let mut worst: Option<Worst> = None;
        for truth in TRUTHS.iter().filter(|truth| truth.is_of(scene)) {
            let fast = f64::from(truth.trajectory.speed_mm_per_s()) > approach.speed_m_per_s * 1e3 + 0.5;
            let straight = matches!(truth.trajectory, Trajectory::Ramp { .. });
            if fast || !(straight || approach.free) {
                continue;
            }
            let rms_pct = match truth.trajectory {
                Trajectory::Ramp { .. } => {
                    Ramp::of(*truth)?.judge_patch(&self.patch, params, approach.site_m)?.ok().map(|e| e.rms_pct)
                }
                _ => CourseError::of(truth, &self.patch, params, approach.site_m)?.ok().map(|e| e.rms_pct),
            };
            if let Some(rms_pct) = rms_pct {
                let own = Worst { rms_pct, motion: truth.trajectory.name() };
                worst = Some(worst.map_or(own, |before| before.or(own)));
            }
        }
        Ok(worst)
    }

    fn cannot_keep(&self, scene: &Scene, approach: Approach, best: &Tried, tried: &[Tried]) -> Error {
        let allowed_pct = allowed_pct(scene);
        let nodes = self.patch.model().nodes.len();
        let keeps = tried.iter().find(|t| t.worst.rms_pct <= allowed_pct);
        let would = match keeps {
            Some(t) => {
                let fewer = (nodes as f64 * t.cost.budget / t.cost.units) as usize;
                format!(
                    "{} substeps would keep it, at {:.0} % of the budget; with them about {fewer} nodes fit",
                    t.substeps,
                    100.0 * t.cost.units / t.cost.budget
                )
            }
            None => {
                let least = tried.iter().map(|t| t.worst.rms_pct).fold(f64::INFINITY, f64::min);
                format!("{least:.1} % is the least that was reached")
            }
        };
        Error::TooSlow(format!(
            "{}: solver.moving_error_pct = {allowed_pct}: at {:.0} mm/s floored masses put the {nodes} nodes {:.1} % off with the {} substep(s) that fit a tick; {would}. Take fewer nodes, move more slowly, or allow more",
            scene.file,
            approach.speed_m_per_s * 1e3,
            best.worst.rms_pct,
            best.substeps,
        ))
    }
}
