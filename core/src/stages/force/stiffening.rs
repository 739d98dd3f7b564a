//! Stiffening: the more energy a deformation stores, the stiffer the tissue becomes.
//!
//! Fung and Demiray's law `W = mu/2b (exp(2 b w / mu) - 1)` is a function of the neo-Hookean energy
//! density w. In this patch w is the energy density of the springs with compensation, so the law is
//! applied node by node: with `w_i` half the energy of every spring at node i over the node's
//! volume, the energy is `sum V_i W(w_i)`, and its exact gradient multiplies the force of a spring
//! from i to j by `(e_i + e_j) / 2`, `e = exp(2 b w / mu)`. The law is conservative and scales with
//! E, and at small strain nothing changes, so one calibrated patch serves every b. The bulk term is
//! unchanged: Demiray's exponent depends on the change of shape alone.
//!
//! A region of another stiffness or another exponent has a steepness of its own: the logarithm of
//! the factor at its nodes is multiplied by [`Model::steepness`], and the energy is divided by it.
//!
//! The foundation is tissue too, namely the part that elements cannot resolve. It counts as a
//! spring does, half at each end: half of a point's energy goes to its node, and half of its push
//! is multiplied by the factor there. The other end is at the probe and has no volume. If the
//! node's half were left out, the tissue under the probe would stay soft: compared with finite
//! elements, 40 % of the force would be missing at b = 20.
//!
//! Beyond `CAP` the factor stays constant, which bounds the stiffness that a tap meets; the energy
//! continues linearly.
//!
//! * in: positions, the probe
//! * out: half of every node's factor in `node.p`, for springs and foundation; volume clears it
//! * cost: a second pass over springs and touched points, 17 % of the tick of 410 nodes; between
//!   the passes springs keep their forces in memory that a board does not have, and the code would
//!   take 17 KB of its flash, so boards leave it out ([`Tuned::stiffens`])
//! * failures: none; an energy that is not finite gives a factor that is not finite either

use nalgebra::Vector3;

use super::foundation::{self, Load};
use super::{gravity, rim, spring, volume};
use crate::lanes::ROW;
use crate::model::{Model, NodeRest};
use crate::params::Tuned;
use crate::state::{Node, State};

/// Largest logarithm of the factor.
pub const CAP: f32 = 4.0;

/// Like [`super::accumulate`], in tissue that stiffens. The pushes of the foundation are summed
/// before the volume term, which overwrites the factors.
#[cfg_attr(feature = "stage-cost", inline(never))]
pub(super) fn accumulate(
    model: &Model,
    tuned: &Tuned,
    state: &mut State,
    tip_m: Vector3<f32>,
    velocity_m_per_s: Vector3<f32>,
) -> Load {
    for node in state.nodes.iter_mut() {
        node.f = [0.0; ROW];
        node.p = 0.0;
    }
    gravity::weigh(model, tuned, state);
    let near = state.near;
    state.near = measure(model, tuned, state, tip_m);
    spring::pull_stiffened(model, tuned, state);
    let mut load = foundation::push::<true>(model, tuned, state, tip_m);
    if tuned.terms.volume {
        for node in state.nodes.iter_mut() {
            node.p = 0.0;
        }
        volume::resist(model, tuned, state);
    }
    if tuned.terms.rim {
        rim::hold(model, state);
    }
    foundation::answer(model, tuned, state, tip_m, velocity_m_per_s, &mut load);
    state.near = near;
    let probe = &tuned.probe;
    load.covered = !probe.shape.has_handle() && foundation::covered(model, state, foundation::centre_m(probe, tip_m), probe);
    load
}

/// Writes half of every node's factor to `node.p`, which must be zero before. Moves the candidates
/// that touch the probe to the front and returns their number.
#[inline(always)]
pub(crate) fn measure(model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>) -> usize {
    spring::store(model, tuned, state);
    let touching = foundation::store(model, tuned, state, tip_m);
    stiffen(model, tuned, state);
    touching
}

/// Turns the energy over E at every node into half of its factor.
#[cfg_attr(feature = "stage-cost", inline(never))]
fn stiffen(model: &Model, tuned: &Tuned, state: &mut State) {
    for (node, steepness) in state.nodes.iter_mut().zip(model.steepness) {
        node.p *= steepness;
    }
    let (nodes, others) = state.nodes.as_chunks_mut::<AT_ONCE>();
    let (rest, rest_of_others) = model.nodes.as_chunks::<AT_ONCE>();
    for (nodes, rest) in nodes.iter_mut().zip(rest) {
        stiffen_group(nodes, rest, tuned);
    }
    for (node, rest) in others.as_chunks_mut::<1>().0.iter_mut().zip(rest_of_others.as_chunks().0) {
        stiffen_group(node, rest, tuned);
    }
}

/// Number of nodes whose factors are computed side by side.
const AT_ONCE: usize = 8;

#[inline(always)]
fn stiffen_group<const W: usize>(nodes: &mut [Node; W], rest: &[NodeRest; W], tuned: &Tuned) {
    let mut half = [0.0; W];
    for ((half, node), rest) in half.iter_mut().zip(nodes.iter()).zip(rest) {
        *half = node.p * rest.six_volume_reciprocal * tuned.steepness;
    }
    for half in &mut half {
        *half = 0.5 * exp(if *half > CAP { CAP } else { *half });
    }
    for (node, half) in nodes.iter_mut().zip(half) {
        node.p = half;
    }
}

/// Exponential of a number from 0 to 10, with the same bits on every target.
#[inline(always)]
pub(crate) fn exp(x: f32) -> f32 {
    // added to a small number, this rounds the number to an integer, which is then in the last bits
    const WHOLE: f32 = 12_582_912.0;
    let rounded = x * core::f32::consts::LOG2_E + WHOLE;
    let r = x - (rounded - WHOLE) * core::f32::consts::LN_2;
    let series = 1.0 + r * (1.0 + r * (1.0 / 2.0 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0))))));
    series * f32::from_bits((rounded.to_bits() << 23).wrapping_add(1.0_f32.to_bits()))
}

#[cfg(test)]
#[allow(clippy::disallowed_types, reason = "the oracle is in double precision")]
mod tests {
    use super::*;

    #[test]
    fn the_series_is_the_exponential() {
        for n in 0..=10_000_u16 {
            let x = f32::from(n) * 1e-3;
            let exact = libm::exp(f64::from(x));
            assert!((f64::from(exp(x)) / exact - 1.0).abs() < 5e-6, "{x}");
        }
        assert!(exp(f32::NAN).is_nan());
    }
}
