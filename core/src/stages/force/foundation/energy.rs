//! Energy that the foundation stores, for tissue that stiffens
//! ([`crate::stages::force::stiffening`]).

use nalgebra::Vector3;

use super::points::{Four, Nine, Points, Sixteen};
use super::{against, centre_m, pushed_out, turned_away};
use crate::lanes::vector;
use crate::model::Model;
use crate::params::Tuned;
use crate::state::{State, node};

/// Adds half of the energy over E of every point to `node.p` of its nodes [m^3]. Moves the
/// candidates that touch the probe to the front and returns their number.
#[cfg_attr(feature = "stage-cost", inline(never))]
pub(in crate::stages::force) fn store(model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>) -> usize {
    match model.points_per_triangle() {
        16 => store_points::<Sixteen, 16>(model, tuned, state, tip_m),
        9 => store_points::<Nine, 9>(model, tuned, state, tip_m),
        _ => store_points::<Four, 4>(model, tuned, state, tip_m),
    }
}

fn store_points<P: Points<Q>, const Q: usize>(model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>) -> usize {
    let laws = model.foundation.as_chunks::<Q>().0;
    let (probe, shaft) = (&tuned.probe, state.shaft);
    let centre = centre_m(probe, tip_m);
    let lift = tip_m + probe.axis * probe.radius_m - centre;
    let third = model.stiffening_per_m * (1.0 / 3.0);
    let mut touching = 0;
    for at in 0..state.near {
        let Some(&candidate) = state.candidates.get(at) else { break };
        let index = usize::from(candidate);
        let (Some(triangle), Some(points_law)) = (model.triangles.get(index), laws.get(index)) else { continue };
        let corners = triangle.node.map(|n| vector(&node(state.nodes, n).x) - centre);
        let (points, against) = (P::at(corners), against(tuned, corners));
        let mut touched = false;
        let energy = core::array::from_fn::<_, Q, _>(|n| {
            let Some((pen, _)) = pushed_out(probe, shaft, points[n], against) else { return 0.0 };
            touched = true;
            points_law[n].k * (pen * pen) * (0.25 + 0.5 * third * pen)
        });
        if !touched || turned_away(corners, lift, probe) {
            continue;
        }
        for (&n, energy) in triangle.node.iter().zip(P::shared(energy)) {
            if let Some(node) = state.nodes.get_mut(usize::from(n)) {
                node.p += energy;
            }
        }
        if let Some(first) = state.candidates.get_mut(touching) {
            let other = core::mem::replace(first, candidate);
            if let Some(slot) = state.candidates.get_mut(at) {
                *slot = other;
            }
            touching += 1;
        }
    }
    touching
}
