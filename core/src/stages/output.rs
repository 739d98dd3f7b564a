//! Converts the load on the tissue into the force on the probe, without the part due to the added
//! mass.
//!
//! * in: the loads of the tick's substeps, the power that the added mass absorbs
//! * out: reaction [N], depth [m], contact point and normal; the touch plane that the next tick's
//!   guard uses
//! * cost: about 110 instructions
//! * failures: [`Fault::ForceNotFinite`]

use nalgebra::Vector3;

use crate::bristle::Rubbed;
use crate::fault::{ClampFlags, Fault};
use crate::inertia::Floored;
use crate::lanes::sqrt;
use crate::model::Model;
use crate::params::Tuned;
use crate::stages::force::foundation::Load;
use crate::stages::presence::Plane;
use crate::stages::probe::{Motion, continuation_m};
use crate::state::{State, TouchPlane};

/// Output of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// Force on the probe [N], patch frame: it points out of the tissue, and with friction along
    /// its surface as well. Zero on any fault.
    pub force_n: Vector3<f32>,
    /// Depth of the tip, or of the deepest point of a long or a turned one, below the undeformed
    /// surface, along the contact normal [m]; zero without contact.
    pub depth_m: f32,
    /// Centre of the contact on the deformed surface [m]; without contact, the tip.
    pub point_m: Vector3<f32>,
    /// Outward unit normal of the contact, which is the direction of the force without friction;
    /// zero without contact.
    pub normal: Vector3<f32>,
    /// Largest force along the surface that the contact can carry [N]; zero without friction.
    pub grip_n: f32,
    /// Share of the force that the guard's spring adds beyond the depth limit, as a length [N]: it
    /// says nothing about the tissue.
    pub continuation_n: f32,
    /// Number of free nodes that moved.
    pub active_nodes: u16,
    /// Distance between the tip that the patch was shown and the sensed tip [m].
    pub apart_m: f32,
    /// True if the sensed tip is outside the tissue, by geometry: no force may then be output.
    pub outside: bool,
    /// Quantities that were clamped.
    pub limiters: ClampFlags,
    /// Reason why the force is zero, if there is one.
    pub fault: Option<Fault>,
}

impl Output {
    /// No contact, no force.
    pub const NONE: Self = Self {
        force_n: Vector3::new(0.0, 0.0, 0.0),
        depth_m: 0.0,
        point_m: Vector3::new(0.0, 0.0, 0.0),
        normal: Vector3::new(0.0, 0.0, 0.0),
        grip_n: 0.0,
        continuation_n: 0.0,
        active_nodes: 0,
        apart_m: 0.0,
        outside: false,
        limiters: ClampFlags::DEFAULT,
        fault: None,
    };
}

/// Returns the mean reaction over the tick's substeps, clamped in magnitude, with its direction
/// kept.
///
/// # Errors
/// Fails with [`Fault::ForceNotFinite`] if the reaction is not finite.
#[cfg_attr(feature = "stage-cost", inline(never))]
pub fn read(
    model: &Model,
    tuned: &Tuned,
    state: &mut State,
    motion: &Motion,
    load: &Load,
    active_nodes: u16,
) -> Result<Output, Fault> {
    let mut out = Output {
        active_nodes,
        limiters: motion.limiters,
        point_m: motion.to_m,
        apart_m: motion.apart_m,
        outside: motion.outside,
        ..Output::NONE
    };
    if load.limited {
        out.limiters.set(ClampFlags::DEPTH);
    }
    if load.covered {
        return Ok(buried(state, out));
    }
    if load.push == 0.0 {
        state.touch = None;
        return Ok(out);
    }
    let mut force_n = load.force * (-tuned.youngs_modulus_pa * tuned.substep_share);
    let square = force_n.dot(&force_n);
    let per_push = 1.0 / load.push;
    if !(square.is_finite() && per_push.is_finite()) {
        return Err(Fault::ForceNotFinite);
    }
    if square == 0.0 {
        // pushed from both sides: no direction, no force
        state.touch = None;
        return Ok(out);
    }
    let mut length = sqrt(square);
    let normal = force_n * (1.0 / length);
    if !tuned.probe.shape.has_handle() && Plane::of(model, load.strongest.1).is_some_and(|at| at.normal.dot(&normal) < 0.0) {
        return Ok(buried(state, out));
    }
    let bare_n = length;
    if motion.velocity_m_per_s.dot(&state.previous_m_per_s) > 0.0 {
        length += without_floor(tuned, &state.floored, motion.velocity_m_per_s, normal, length);
    }
    if !length.is_finite() {
        return Err(Fault::ForceNotFinite);
    }
    force_n = normal * length;
    let (rubs, continues) = (tuned.remembers && tuned.rubs(), motion.beyond_m != Vector3::zeros());
    if rubs {
        // friction shrinks in proportion to the push that carries it
        let kept = if length < bare_n { length / bare_n } else { 1.0 };
        (force_n, out.grip_n) = rub(tuned, &state.rubbed, force_n, kept);
    }
    if continues {
        let stiffness_m = continuation_m(&tuned.probe, model.poisson_ratio, model.depth_limit_m);
        let continuation_n = motion.beyond_m * (stiffness_m * tuned.youngs_modulus_pa);
        out.continuation_n = sqrt(continuation_n.dot(&continuation_n));
        force_n += continuation_n;
    }
    if rubs || continues {
        let square = force_n.dot(&force_n);
        if !square.is_finite() {
            return Err(Fault::ForceNotFinite);
        }
        if square > tuned.limits.max_force_n * tuned.limits.max_force_n {
            // push, friction and continuation are clamped together
            let share = tuned.limits.max_force_n / sqrt(square);
            force_n *= share;
            out.grip_n *= share;
            out.continuation_n *= share;
            out.limiters.set(ClampFlags::FORCE);
        }
    } else if length > tuned.limits.max_force_n {
        force_n = normal * tuned.limits.max_force_n;
        out.limiters.set(ClampFlags::FORCE);
    }
    let rest_m = load.rest * per_push;
    let depth_m = (rest_m - motion.to_m + motion.beyond_m).dot(&normal) + tuned.contact_below_tip_m(&normal);
    state.touch = Some(TouchPlane { rest_m, normal });
    state.over = Some(load.strongest.1);
    out.force_n = force_n;
    out.depth_m = if depth_m > 0.0 { depth_m } else { 0.0 };
    out.point_m = load.point * per_push;
    out.normal = normal;
    Ok(out)
}

/// Output for a tip without a handle that is below the surface. Where elements are as wide as the
/// tip, it slips past them, and their push may have any direction, so there is no force until the
/// tip has been outside.
#[inline(never)]
fn buried(state: &mut State, mut out: Output) -> Output {
    (state.touch, state.been_outside) = (None, false);
    out.limiters.set(ClampFlags::BURIED);
    out
}

/// Change of the push [N] that keeps the hand from feeling the masses added by the floor: their
/// power over the probe's speed, along the push. The work on the hand is then that of true masses,
/// as far as the tissue moves as it would with them. Tissue that is faster than the probe moves by
/// itself, and only the probe's share of that power counts. The push may vanish or double at most;
/// its direction does not change.
///
/// The power belongs to the nodes' mean velocity in the substep, so it does not apply to a probe
/// that has just stopped or turned round, nor to one that trembles by a count: the push changes
/// only if the probe moves the same way in two ticks in a row.
#[inline(always)]
fn without_floor(tuned: &Tuned, floored: &Floored, probe_m_per_s: Vector3<f32>, normal: Vector3<f32>, push_n: f32) -> f32 {
    let power_w = floored.power * tuned.youngs_modulus_pa * tuned.substep_share;
    let square = probe_m_per_s.dot(&probe_m_per_s);
    let fastest = if square > floored.fastest { square } else { floored.fastest };
    let gain_n = power_w * probe_m_per_s.dot(&normal);
    let most_n = push_n * fastest;
    // compared without a division, so that a probe and a tissue at rest gain nothing
    if gain_n > most_n {
        push_n
    } else if gain_n < -most_n {
        -push_n
    } else if fastest > 0.0 {
        gain_n / fastest
    } else {
        0.0
    }
}

/// Returns the force with friction [N] and the largest force that friction could carry [N], if the
/// share `kept` of the push is left.
#[inline(never)]
fn rub(tuned: &Tuned, rubbed: &Rubbed, push_n: Vector3<f32>, kept: f32) -> (Vector3<f32>, f32) {
    let newtons = tuned.youngs_modulus_pa * tuned.substep_share * kept;
    (push_n - rubbed.force * newtons, rubbed.most * newtons)
}
