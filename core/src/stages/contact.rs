//! Broad phase: the surface triangles that the probe can reach in this tick.
//!
//! * in: the tip's displacement in the tick, node positions
//! * out: `state.candidates`, ascending; empty until the tick after the one in which the probe is
//!   first found outside the tissue
//! * cost: up to 18 comparisons per triangle; most triangles are rejected after 3
//! * failures: none; a superfluous triangle costs time only

use nalgebra::Vector3;

use crate::fault::ClampFlags;
use crate::model::Model;
use crate::params::{Probe, Tuned};
use crate::stages::force::foundation;
use crate::stages::presence;
use crate::stages::probe::Motion;
use crate::state::State;

/// Writes the triangles whose box meets the probe's box.
#[cfg_attr(feature = "stage-cost", inline(never))]
pub fn find(model: &Model, tuned: &Tuned, state: &mut State, motion: &mut Motion) {
    let (low, high) = reach(&tuned.probe, model.depth_limit_m, motion);
    let mut near = 0;
    for (index, triangle) in model.triangles.iter().enumerate() {
        let [a, b, c] = triangle.node.map(|n| state.nodes.get(usize::from(n)));
        let (Some(a), Some(b), Some(c)) = (a, b, c) else { continue };
        let apart = (0..3).any(|k| {
            (a.x[k] < low[k] && b.x[k] < low[k] && c.x[k] < low[k]) || (a.x[k] > high[k] && b.x[k] > high[k] && c.x[k] > high[k])
        });
        if !apart && let Some(slot) = state.candidates.get_mut(near) {
            *slot = index as u16;
            near += 1;
        }
    }
    state.near = near;
    if !state.been_outside {
        // in every tick, so that the body's walk is not left behind by a tip that goes on inside
        let buried = presence::buried(model, tuned, state, motion.to_m);
        state.been_outside = !state.seat.inside() && !buried && !foundation::touches(model, tuned, state, motion.to_m);
        // nothing is pressed in the tick in which the probe is first found outside: that tick has
        // already searched the points once
        state.near = 0;
        if !state.been_outside {
            motion.limiters.set(ClampFlags::BURIED);
        }
    }
}

/// Box around the volume that the probe sweeps in the tick [m]. For a hemisphere or a flat end it
/// extends along the axis, because these carry a cylinder.
fn reach(probe: &Probe, depth_limit_m: f32, motion: &Motion) -> (Vector3<f32>, Vector3<f32>) {
    let diameter = 2.0 * probe.radius_m;
    let length = if probe.shape.has_handle() { diameter + depth_limit_m } else { diameter };
    let mut low = Vector3::zeros();
    let mut high = Vector3::zeros();
    for k in 0..3 {
        let (from, to) = (motion.from_m[k], motion.to_m[k]);
        let (first, last) = if from < to { (from, to) } else { (to, from) };
        let along = probe.axis[k] * length;
        let r = probe.half_width_m(k);
        low[k] = first - r + if along < 0.0 { along } else { 0.0 };
        high[k] = last + r + if along > 0.0 { along } else { 0.0 };
    }
    (low, high)
}

#[cfg(test)]
mod tests;
