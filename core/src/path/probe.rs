//! Guard: what the device says becomes what the patch is shown.
//!
//! Into tissue the tip goes at most `Limits::max_sink_m_per_s`, out of it at any speed: a fast tap arrives late and weaker, and what the limit takes
//! from the way in is never given back on the way out.
//!
//! * in: tip position as sensed, [m], patch frame
//! * out: the straight way the tip moves in this tick, speed and depth clamped
//! * cost: about 80 instructions
//! * may fail: [`Fault::PoseNotFinite`]

use nalgebra::Vector3;

use crate::fault::{Fault, Limiters};
use crate::lanes::sqrt;
use crate::model::Model;
use crate::params::Tuned;
use crate::state::State;

/// Where the probe is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbePose {
    /// Tip [m], patch frame.
    pub tip_m: Vector3<f32>,
}

/// The way of the tip in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Tip at the end of the last tick [m].
    pub from_m: Vector3<f32>,
    /// Tip at the end of this tick [m].
    pub to_m: Vector3<f32>,
    /// Velocity between the two [m/s].
    pub velocity_m_per_s: Vector3<f32>,
    /// What was clamped.
    pub limiters: Limiters,
}

impl Motion {
    /// Tip at a share of the tick (0 .. 1) [m].
    #[inline(always)]
    pub(crate) fn at(&self, share: f32) -> Vector3<f32> {
        self.from_m + (self.to_m - self.from_m) * share
    }
}

/// Admits a pose: finite, no faster than the speed limits, no deeper than the patch answers.
///
/// # Errors
/// [`Fault::PoseNotFinite`]; nothing changes then.
#[cfg_attr(feature = "stage-cost", inline(never))]
pub fn admit(model: &Model, tuned: &Tuned, state: &mut State, pose: ProbePose) -> Result<Motion, Fault> {
    if !pose.tip_m.iter().all(|c| c.is_finite()) {
        return Err(Fault::PoseNotFinite);
    }
    let from_m = state.tip_m.unwrap_or(pose.tip_m);
    let mut limiters = Limiters::default();

    let mut step = pose.tip_m - from_m;
    let longest = tuned.limits.max_speed_m_per_s * tuned.substep_s * f32::from(tuned.substeps);
    let square = step.dot(&step);
    if square > longest * longest {
        // too far for the square to be finite: the limit holds all the same, in the direction that is left
        step = if square.is_finite() { step * (longest / sqrt(square)) } else { Vector3::zeros() };
        limiters.set(Limiters::SPEED);
    }
    state.pressed = state.touch.or(state.pressed).filter(|at| state.near > 0 && (at.rest_m - from_m).dot(&at.normal) >= 0.0);
    if let Some(at) = state.pressed {
        let sink_m = -step.dot(&at.normal);
        let most_m = tuned.limits.max_sink_m_per_s * tuned.substep_s * f32::from(tuned.substeps);
        if sink_m > most_m {
            // along its own way: along the normal of a tilted contact it would slip deeper, or aside
            step *= most_m / sink_m;
            limiters.set(Limiters::SPEED);
        }
    }
    let mut to_m = from_m + step;

    if let Some(touch) = state.touch {
        let beyond = (touch.rest_m - to_m).dot(&touch.normal) - model.depth_limit_m;
        if beyond > 0.0 {
            to_m += touch.normal * beyond;
            limiters.set(Limiters::DEPTH);
        }
    }
    state.tip_m = Some(to_m);
    let velocity_m_per_s = (to_m - from_m) * tuned.ticks_per_s;
    Ok(Motion { from_m, to_m, velocity_m_per_s, limiters })
}
