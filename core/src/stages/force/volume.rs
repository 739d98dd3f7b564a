//! Volume energy: nodal-averaged, with a small per-tet share.
//!
//! Springs alone are a solid with Poisson's ratio 1/4. The bulk stiffness missing for the wanted
//! ratio is `kappa = lambda - mu`, added as `sum_n V_n kappa w(J_n)` with
//! `J_n = sum V_t / sum V_t0` over the node's tets and `w' = 2 (J - 1) / (J (J + 1))`: as stiff as
//! `ln J / J` to second order, without a logarithm, and linear below J = 0.8. The nodal average
//! does not lock, but alone it lets neighbouring tets exchange volume. So a share beta acts per
//! tet, and a barrier opens tets below 0.4 of their rest volume (`compensation`).
//!
//! * in: positions
//! * out: adds to `node.f`; leaves each node's pressure over E in `node.p`
//! * cost (M4F, estimated): about 70 + 146 cycles per tet, 33 per node
//! * failures: none

#[cfg(not(armv7em_fp))]
mod tets;

#[cfg(armv7em_fp)]
use super::armv7em::{measure, push};
use crate::lanes::Lanes;
use crate::model::{Model, NodeRest};
use crate::params::Tuned;
use crate::state::{Node, State};
#[cfg(not(armv7em_fp))]
use tets::{measure, push};

/// Below this share of its rest volume a node's pressure continues along its tangent. Down to 0.3
/// the formula itself would become twenty times as stiff, and no step of a millisecond is stable
/// there. This matters for taps only: the static force of a hemisphere pressed in by its radius
/// changes by less than 0.03 %.
pub const STRAIGHT_BELOW: f32 = 0.8;
/// Slope of `(J - 1) / (J (J + 1))` there: `(1 + 2 J - J^2) / (J (J + 1))^2`.
const STRAIGHT_SLOPE: f32 = 0.945_216_05;

/// Adds the volume forces over E [N/Pa].
#[inline(always)]
pub fn resist(model: &Model, tuned: &Tuned, state: &mut State) {
    let Some(tets) = measure(model.tets, state) else { return };
    pressurise(model.nodes, state.nodes);
    match tuned.terms.compensation {
        true => push::<true>(tets, state),
        false => push::<false>(tets, state),
    }
}

/// Turns every node's volume into its pressure over E, divided by 24 (a quarter for each corner, a
/// sixth for the gradient).
#[cfg_attr(feature = "stage-cost", inline(never))]
fn pressurise(rest: &[NodeRest], nodes: &mut [Node]) {
    for (node, rest) in nodes.iter_mut().zip(rest) {
        let ratio = node.p * rest.six_volume_reciprocal;
        let j = Lanes::<1>::at_least(ratio, STRAIGHT_BELOW);
        node.p = rest.pressure * ((j - 1.0) / (j * (j + 1.0)) + STRAIGHT_SLOPE * (ratio - j));
    }
}
