//! Force error on a ramp, against the stored dynamic reference.

use palpate::{Fault, Params, ProbePose, Vector3, tick};
use serde::{Deserialize, Serialize};

use super::table::Table;
use super::truth::{TRUTHS, Trajectory, Truth};
use crate::error::Error;
use crate::patch::{Memory, Patch};
use crate::scene::Scene;
use crate::truth_error::TruthError;

/// Depth of the stored ramps [m].
const DEPTH_M: f64 = 0.004;
/// Depths at which errors are reported separately [m].
pub const AT_M: [f64; 4] = [0.001, 0.002, 0.003, 0.004];
/// Ticks above the surface before the ramp.
const LEAD_TICKS: i32 = 5;
/// Ticks of the hold after the ramp.
const HOLD_TICKS: i32 = 40;
/// Number of ticks after the stop that are evaluated as well: there floored masses are felt most.
const AFTER_STOP_TICKS: i32 = 20;

/// A stored ramp with its table, ready for comparison.
#[derive(Clone, Debug)]
pub struct Ramp {
    /// Stored reference of the ramp.
    pub truth: Truth,
    /// Speed of the ramp [mm/s].
    pub speed_mm_per_s: u32,
    table: Table,
}

/// Force errors of a ramp to 4 mm, and of the hold after it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RampError {
    /// Speed of the ramp [mm/s].
    pub speed_mm_per_s: u32,
    /// Error at each of [`AT_M`], relative to the reference force there [%].
    pub at_pct: [f64; 4],
    /// Root mean square over the ramp and the 20 ms after its stop, relative to its largest
    /// reference force [%].
    pub rms_pct: f64,
    /// Error of the largest force, including the hold [%].
    pub peak_pct: f64,
}

impl Ramp {
    /// Reads the table of a stored ramp.
    ///
    /// # Errors
    /// The motion is not a ramp, or the table cannot be read.
    pub fn of(truth: Truth) -> Result<Self, TruthError> {
        let Trajectory::Ramp { speed_mm_per_s, .. } = truth.trajectory else {
            return Err(TruthError::NoRamp { name: truth.name });
        };
        Ok(Self { truth, speed_mm_per_s, table: truth.stored()? })
    }

    /// Reads the stored ramp of this name.
    ///
    /// # Errors
    /// Errors of [`Self::of`], and an unknown name.
    pub fn named(name: &str) -> Result<Self, TruthError> {
        Self::of(Truth::named(name)?)
    }

    /// The stored ramps with a scene's tissue, probe and place, slowest first. The scene's own
    /// drive does not matter. Empty if no dynamic reference is stored for the scene.
    ///
    /// # Errors
    /// Errors of [`Self::of`].
    pub fn of_scene(scene: &Scene) -> Result<Vec<Self>, TruthError> {
        let ramps = TRUTHS.into_iter().filter(|truth| matches!(truth.trajectory, Trajectory::Ramp { .. }) && truth.is_of(scene));
        let mut ramps = ramps.map(Self::of).collect::<Result<Vec<_>, _>>()?;
        ramps.sort_by_key(|ramp| ramp.speed_mm_per_s);
        Ok(ramps)
    }

    /// Depths of the tip at the end of each millisecond [m], in the order in which [`Self::judge`]
    /// commands them.
    #[must_use]
    pub fn depths_m(&self) -> Vec<f64> {
        (-LEAD_TICKS..=self.ticks() + HOLD_TICKS).map(|n| self.depth_m(n)).collect()
    }

    /// Reference force over Young's modulus at each tick that is evaluated [m^2]; the first is the
    /// tick after the touch.
    #[must_use]
    pub fn judged_force_over_e_m2(&self) -> Vec<f64> {
        (1..=self.judged_ticks()).map(|n| self.table.force_over_e_m2(f64::from(n) * 1e-3)[2]).collect()
    }

    /// Number of ticks from the touch to the stop.
    fn ticks(&self) -> i32 {
        (DEPTH_M / self.step_m()).round() as i32
    }

    fn judged_ticks(&self) -> i32 {
        self.ticks() + AFTER_STOP_TICKS
    }

    /// Displacement per tick [m].
    fn step_m(&self) -> f64 {
        f64::from(self.speed_mm_per_s) * 1e-6
    }

    fn depth_m(&self, tick: i32) -> f64 {
        (self.step_m() * f64::from(tick)).min(DEPTH_M)
    }

    /// Moves a probe as in the reference and compares the forces. `tick` receives the depth of the
    /// tip at the end of each millisecond [m] and returns the force on the probe along the press
    /// [N].
    ///
    /// # Errors
    /// Returns the first error of `tick`.
    pub fn judge<E>(&self, mut tick: impl FnMut(f64) -> Result<f64, E>) -> Result<RampError, E> {
        let true_m2 = |t_s: f64| self.table.force_over_e_m2(t_s)[2];
        let step_m = self.step_m();
        let mut force_m2 = Vec::new();
        for n in -LEAD_TICKS..=self.ticks() + HOLD_TICKS {
            let force_n = tick(self.depth_m(n))?;
            if n >= 0 {
                force_m2.push(force_n / self.truth.youngs_modulus_pa);
            }
        }
        // between two ticks the force is interpolated linearly
        let own_m2 = |ticks: f64| {
            let before = (ticks + 1e-6).floor();
            let share = (ticks - before).max(0.0);
            let at = |n: f64| force_m2[(n as usize).min(force_m2.len() - 1)];
            at(before) * (1.0 - share) + at(before + 1.0) * share
        };
        let at_pct = AT_M.map(|depth_m| (own_m2(depth_m / step_m) / true_m2(depth_m / step_m * 1e-3) - 1.0) * 100.0);
        let judged = self.judged_ticks();
        let ticks = || (1..=judged).map(|n| (force_m2[n as usize], true_m2(f64::from(n) * 1e-3)));
        let mean_square = ticks().map(|(own, wanted)| (own - wanted).powi(2)).sum::<f64>() / f64::from(judged);
        let largest = ticks().map(|(_, wanted)| wanted).fold(0.0, f64::max);
        let true_peak = self.table.rows.iter().map(|row| row.force_over_e_m2[2]).fold(0.0, f64::max);
        let peak = force_m2.iter().copied().fold(0.0, f64::max);
        Ok(RampError {
            speed_mm_per_s: self.speed_mm_per_s,
            at_pct,
            rms_pct: mean_square.sqrt() / largest * 100.0,
            peak_pct: (peak / true_peak - 1.0) * 100.0,
        })
    }

    /// Judges a patch that is pressed at a place of its surface [m].
    ///
    /// # Errors
    /// A model that the core refuses; the inner error is the fault of a patch that does not survive
    /// the ramp.
    pub fn judge_patch(&self, patch: &Patch, params: &Params, site_m: Vector3<f32>) -> Result<Result<RampError, Fault>, Error> {
        let model = patch.wide_model();
        let mut memory = Memory::for_model(&model);
        let params = Params { youngs_modulus_pa: self.truth.youngs_modulus_pa as f32, ..*params };
        let (tuned, mut state) = memory.start(&model, &params)?;
        let axis = params.probe.axis;
        Ok(self.judge(|depth_m| {
            let out = tick(&model, &tuned, &mut state, ProbePose { tip_m: site_m - axis * depth_m as f32 });
            out.fault.map_or(Ok(f64::from(out.force_n.dot(&axis))), Err)
        }))
    }
}
