//! Guard: derives the tip that the patch is given (the *shown* tip) from the sensed tip.
//!
//! In contact the shown tip enters the tissue no faster than `GuardLimits::max_sink_m_per_s`, but
//! leaves it without that limit: a fast tap arrives late and weaker, and the energy that the limit
//! withholds from the tissue during loading is never returned during unloading. Where there can be
//! no contact ([`Presence::Outside`]), the shown tip **is** the sensed tip, whatever its speed.
//!
//! The shown tip goes no deeper than the patch's depth limit. Beyond it the force continues: a
//! spring with the stiffness of a Hertz contact at the limit ([`continuation_m`]) acts
//! between the sensed tip and the point at which the limit was met, along the normal there. Its
//! force is a function of place alone until the limit is left, so it returns what it took. After a
//! slide beyond the limit the shown tip keeps its distance, and the spring ends.
//!
//! * in: sensed tip [m], patch frame; its [`Presence`]
//! * out: the straight displacement of the shown tip in this tick, with speed and depth clamped;
//!   how far the sensed tip is beyond the limit
//! * cost: about 80 instructions, and those of [`super::presence`]
//! * failures: [`Fault::PoseNotFinite`]

use nalgebra::Vector3;

use crate::fault::{ClampFlags, Fault};
use crate::lanes::{sqrt, square_root};
use crate::model::Model;
use crate::params::{Probe, ProbeShape, Tuned};
use crate::stages::presence::{self, Presence};
use crate::state::{State, TouchPlane};

/// Distance between the shown and the sensed tip, in radii of the probe (1), beyond which the hand
/// has pushed through. The force at the shown tip then says nothing about the tissue at the sensed
/// tip, so there is none until a fresh approach. A hand that continues speeds up against the force
/// as it would with a wrong sign; with three radii this was mistaken for [`Fault::Runaway`].
const THROUGH_RADII: f32 = 2.0;
/// Distance between the two tips, in radii of the probe (1), beyond which a tip that outran the
/// speed limit has passed the surface untouched.
const OUTRAN_RADII: f32 = 1.0;
/// Tangential displacement at the depth limit [m] after which the depth by which the shown tip lags
/// behind the sensed one is kept as an offset.
const SLID_M: f32 = 1e-3;
/// Rounding error of a position in a workspace of metres [m]: a press exactly to the limit is not
/// beyond it.
const ROUNDING_M: f32 = 1e-7;

/// Pose of the probe that is passed to a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbePose {
    /// Tip [m], patch frame.
    pub tip_m: Vector3<f32>,
}

/// Displacement of the shown tip in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Tip at the end of the last tick [m].
    pub from_m: Vector3<f32>,
    /// Tip at the end of this tick [m].
    pub to_m: Vector3<f32>,
    /// Velocity of the shown tip over the tick [m/s].
    pub velocity_m_per_s: Vector3<f32>,
    /// Distance between the shown and the sensed tip at the end of this tick [m].
    pub apart_m: f32,
    /// Distance of the sensed tip beyond the place at which the depth limit was met, outwards along
    /// the normal there [m]; zero unless the limit acts.
    pub beyond_m: Vector3<f32>,
    /// True if no contact is possible at the sensed tip.
    pub outside: bool,
    /// Quantities that were clamped.
    pub limiters: ClampFlags,
}

impl Motion {
    /// Tip at a share of the tick (0 .. 1) [m].
    #[inline(always)]
    pub(crate) fn at(&self, share: f32) -> Vector3<f32> {
        self.from_m + (self.to_m - self.from_m) * share
    }
}

/// Stiffness over Young's modulus [m] with which the force continues beyond a depth limit: twice
/// the radius of a Hertz contact there, times the plane modulus over Young's. As deep as the probe
/// is wide, that radius is a fifth larger than on a half-space (Sneddon, Int. J. Engineering
/// Science 3, 1965), and finite thickness stiffens tissue by as much: on the shipped patches with a
/// limit of 5 mm, the force 8 mm deep is 3 to 4 % too low.
#[must_use]
#[inline(never)]
pub fn continuation_m(probe: &Probe, poisson_ratio: f32, limit_m: f32) -> f32 {
    let radius_m = match probe.shape {
        ProbeShape::Flat => probe.radius_m,
        _ if limit_m < probe.radius_m => square_root(probe.radius_m * limit_m),
        _ => probe.radius_m,
    };
    2.0 * radius_m / (1.0 - poisson_ratio * poisson_ratio)
}

/// Admits a finite pose and derives from it the motion of the shown tip, within the limits of speed
/// and depth.
///
/// # Errors
/// [`Fault::PoseNotFinite`]; nothing changes then.
#[cfg_attr(feature = "stage-cost", inline(never))]
pub fn admit(model: &Model, tuned: &Tuned, state: &mut State, pose: ProbePose) -> Result<Motion, Fault> {
    if !pose.tip_m.iter().all(|c| c.is_finite()) {
        return Err(Fault::PoseNotFinite);
    }
    let from_m = state.tip_m.unwrap_or(pose.tip_m);
    let below_m = |at: &TouchPlane| (at.rest_m - from_m).dot(&at.normal) + tuned.contact_below_tip_m(&at.normal);
    state.pressed = state.touch.or(state.pressed).filter(|at| state.near > 0 && below_m(at) >= 0.0);
    let (presence, plane) = presence::locate(model, tuned, state, pose.tip_m);
    let mut limiters = ClampFlags::default();

    let mut step = pose.tip_m - from_m;
    let square = step.dot(&step);
    let longest = tuned.limits.max_speed_m_per_s * tuned.substep_s * f32::from(tuned.substeps);
    let outside = presence == Presence::Outside;
    if outside || !state.been_outside {
        // a jump does not sweep through the space between its ends
        let swept = !state.apart && square <= longest * longest;
        (state.touch, state.pressed, state.apart, state.tip_m) = (None, None, false, Some(pose.tip_m));
        (state.offset_m, state.limit) = (Vector3::zeros(), None);
        let from_m = if swept { from_m } else { pose.tip_m };
        let velocity_m_per_s = (pose.tip_m - from_m) * tuned.ticks_per_s;
        let beyond_m = Vector3::zeros();
        return Ok(Motion { from_m, to_m: pose.tip_m, velocity_m_per_s, apart_m: 0.0, beyond_m, outside, limiters });
    }
    step += state.offset_m;
    let square = step.dot(&step);
    if square > longest * longest {
        // a displacement whose square overflows has no usable direction: the shown tip stays
        step = if square.is_finite() { step * (longest / sqrt(square)) } else { Vector3::zeros() };
        limiters.set(ClampFlags::SPEED);
    }
    if let Some(at) = state.pressed {
        let sink_m = -step.dot(&at.normal);
        let most_m = tuned.limits.max_sink_m_per_s * tuned.substep_s * f32::from(tuned.substeps);
        if sink_m > most_m {
            // the whole displacement is shortened: if only its part along the normal of a tilted
            // contact were, the tip would slip deeper or sideways
            step *= most_m / sink_m;
            limiters.set(ClampFlags::SPEED);
        }
    }
    let mut to_m = from_m + step;

    // The depth is measured below the *rest* surface: a plane that followed the contact would move
    // with the tip that it limits. The force at the limit differs from place to place. So, once a
    // hand slides at the limit, the depth by which the shown tip lags behind the sensed one is kept
    // as an offset; otherwise a hand that slides to a place with a larger force would be pushed out
    // of a depth that cost it less work elsewhere. A hand that moves straight in and out feels the
    // same force in both directions.
    if let Some(plane) = plane {
        let beyond_m = plane.probe_depth_m(&tuned.probe, to_m) - model.depth_limit_m;
        if beyond_m > ROUNDING_M {
            to_m += plane.normal * beyond_m;
            // the continuation starts without a force, whichever triangle the limit is measured at
            let limit = state.limit.filter(|_| state.touch.is_some()).unwrap_or_else(|| {
                let [to, from] = [to_m, from_m].map(|m| (m - pose.tip_m).dot(&plane.normal));
                let back_m = if state.touch.is_none() { 0.0 } else { if from < to { from } else { to } };
                TouchPlane { rest_m: pose.tip_m + plane.normal * back_m, normal: plane.normal }
            });
            state.limit = Some(limit);
            let displacement_m = pose.tip_m - limit.rest_m;
            let aside_m = displacement_m - plane.normal * displacement_m.dot(&plane.normal);
            if state.offset_m != Vector3::zeros() {
                state.offset_m += plane.normal * beyond_m;
            } else if aside_m.dot(&aside_m) > SLID_M * SLID_M {
                state.offset_m = plane.normal * (to_m - pose.tip_m).dot(&plane.normal);
            }
            limiters.set(ClampFlags::DEPTH);
        } else if state.offset_m == Vector3::zeros() {
            state.limit = None;
        }
    }
    if state.offset_m != Vector3::zeros() {
        limiters.set(ClampFlags::DEPTH);
    }
    let mut beyond_m = Vector3::zeros();
    if let Some(limit) = state.limit {
        let depth_m = (limit.rest_m - pose.tip_m - state.offset_m).dot(&limit.normal);
        if depth_m > 0.0 {
            beyond_m = limit.normal * depth_m;
        }
    }
    state.tip_m = Some(to_m);
    // only clamping counts, not a difference by rounding
    state.apart = limiters != ClampFlags::DEFAULT;
    let off_m = pose.tip_m - to_m;
    let apart_m = if state.apart { sqrt(off_m.dot(&off_m)) } else { 0.0 };
    let steep = plane.is_some_and(|plane| plane.steep(tuned.up()));
    if state.apart || steep {
        let most_radii = if state.pressed.is_none() { OUTRAN_RADII } else { THROUGH_RADII };
        let through = apart_m > most_radii * tuned.probe.radius_m;
        if through || presence::buried(model, tuned, state, to_m) {
            state.been_outside = false;
        }
    }
    let velocity_m_per_s = (to_m - from_m) * tuned.ticks_per_s;
    Ok(Motion { from_m, to_m, velocity_m_per_s, apart_m, beyond_m, outside, limiters })
}
