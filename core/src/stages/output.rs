//! The load on the tissue becomes the force on the probe, without what the mass floor takes.
//!
//! * in: the loads of the tick's substeps, the power of the floored masses
//! * out: reaction [N], depth [m], contact point and normal; the touch plane that the next tick's
//!   guard uses
//! * cost: about 110 instructions
//! * may fail: [`Fault::ForceNotFinite`]

use nalgebra::Vector3;

use crate::fault::{ClampFlags, Fault};
use crate::inertia::Floored;
use crate::lanes::sqrt;
use crate::model::Model;
use crate::params::Tuned;
use crate::stages::force::foundation::Load;
use crate::stages::force::friction::Rubbed;
use crate::stages::presence::Plane;
use crate::stages::probe::Motion;
use crate::state::{State, TouchPlane};

/// Output of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// Force on the probe [N], patch frame: it points out of the tissue, and with friction along
    /// its surface as well. Zero on any fault.
    pub force_n: Vector3<f32>,
    /// How deep the tip is below the undeformed surface, along the contact normal [m]; zero without
    /// contact.
    pub depth_m: f32,
    /// Centre of the contact on the deformed surface [m]; the tip without contact.
    pub point_m: Vector3<f32>,
    /// Outward unit normal of the contact, the direction of the force but for friction; zero
    /// without contact.
    pub normal: Vector3<f32>,
    /// Largest force along the surface that the contact can bear [N]; zero without friction.
    pub grip_n: f32,
    /// Free nodes that moved.
    pub active_nodes: u16,
    /// Distance of the tip that the patch was shown from the one that was sensed [m].
    pub apart_m: f32,
    /// The sensed tip is outside the tissue, by geometry: no force may be felt.
    pub outside: bool,
    /// Inputs that were clamped.
    pub limiters: ClampFlags,
    /// Why the force is zero.
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
        active_nodes: 0,
        apart_m: 0.0,
        outside: false,
        limiters: ClampFlags::DEFAULT,
        fault: None,
    };
}

/// Mean reaction over the tick's substeps, clamped in length, its direction kept.
///
/// # Errors
/// [`Fault::ForceNotFinite`].
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
    if tuned.remembers && tuned.rubs() {
        // friction is lost with the push that bears it
        let kept = if length < bare_n { length / bare_n } else { 1.0 };
        (force_n, out.grip_n) = rub(tuned, &state.rubbed, force_n, kept);
        let square = force_n.dot(&force_n);
        if !square.is_finite() {
            return Err(Fault::ForceNotFinite);
        }
        if square > tuned.limits.max_force_n * tuned.limits.max_force_n {
            // push and friction as one
            let share = tuned.limits.max_force_n / sqrt(square);
            force_n *= share;
            out.grip_n *= share;
            out.limiters.set(ClampFlags::FORCE);
        }
    } else if length > tuned.limits.max_force_n {
        force_n = normal * tuned.limits.max_force_n;
        out.limiters.set(ClampFlags::FORCE);
    }
    let rest_m = load.rest * per_push;
    let depth_m = (rest_m - motion.to_m).dot(&normal);
    state.touch = Some(TouchPlane { rest_m, normal });
    state.over = Some(load.strongest.1);
    out.force_n = force_n;
    out.depth_m = if depth_m > 0.0 { depth_m } else { 0.0 };
    out.point_m = load.point * per_push;
    out.normal = normal;
    Ok(out)
}

/// A tip without a handle that is below the surface: where elements are as wide as it is, it slips
/// past them, and their push points anywhere. There is no force before it has been outside.
#[inline(never)]
fn buried(state: &mut State, mut out: Output) -> Output {
    (state.touch, state.been_outside) = (None, false);
    out.limiters.set(ClampFlags::BURIED);
    out
}

/// Gain of the push [N] if the hand does not feel the masses that the floor added: their power over
/// the probe's speed, along the push. The work on the hand is then that of true masses, as far as
/// the tissue moves as it would with them. Tissue that is faster than the probe moves by itself,
/// and only the probe's share of that power counts. The push may vanish or double; its direction
/// stays.
///
/// The power is that of the nodes' mean velocity in the substep, so it says nothing about a probe
/// that has just stopped or turned round, nor about one that trembles by a count: there is no gain
/// unless two ticks in a row go the same way.
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

/// Force with friction [N], and the largest force that friction could bear [N], where a share of
/// the push is `kept`.
#[inline(never)]
fn rub(tuned: &Tuned, rubbed: &Rubbed, push_n: Vector3<f32>, kept: f32) -> (Vector3<f32>, f32) {
    let newtons = tuned.youngs_modulus_pa * tuned.substep_share * kept;
    (push_n - rubbed.force * newtons, rubbed.most * newtons)
}
