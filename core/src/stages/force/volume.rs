//! Volume energy: nodal-averaged, with a small per-tet share.
//!
//! Springs alone are a solid with Poisson's ratio 1/4. What is missing to the wanted ratio is
//! `kappa = lambda - mu`, added as `sum_n V_n kappa w(J_n)` with `J_n = sum V_t / sum V_t0` over
//! the node's tets and `w' = 2 (J - 1) / (J (J + 1))`: as stiff as `ln J / J` to second order,
//! without a logarithm; straight below J = 0.8. Averaging over nodes does not lock; alone it lets
//! neighbouring tets trade volume, so a share beta acts per tet, and a barrier opens tets below 0.4
//! of their volume (`compensation`).
//!
//! * in: positions
//! * out: adds to `node.f`; leaves each node's pressure over E in `node.p`
//! * cost (M4F, estimated): about 85 + 186 cycles per tet, 33 per node
//! * may fail: never

use nalgebra::Vector3;

use super::compensation;
use crate::lanes::{Lanes, subtract};
use crate::model::{Model, NodeRest, Tet};
use crate::params::Tuned;
#[cfg(not(target_os = "none"))]
use crate::state::TetShapes;
use crate::state::{Node, State, node};

/// Below this share of its rest volume a node's pressure goes on along its tangent. The formula
/// would stiffen twentyfold until 0.3, where no millisecond step holds. That is for taps: the
/// static force of a hemisphere pressed in by its radius does not see it (less than 0.03 %).
pub const STRAIGHT_BELOW: f32 = 0.8;
/// Slope of `(J - 1) / (J (J + 1))` there: `(1 + 2 J - J^2) / (J (J + 1))^2`.
const STRAIGHT_SLOPE: f32 = 0.945_216_05;

/// Adds the volume forces over E [N/Pa].
#[inline(always)]
pub fn resist(model: &Model, tuned: &Tuned, state: &mut State) {
    measure(model.tets, state);
    pressurise(model.nodes, state.nodes);
    match tuned.terms.compensation {
        true => push::<true>(model.tets, state),
        false => push::<false>(model.tets, state),
    }
}

/// Six times the volume of the tets around every node [m^3].
#[cfg_attr(feature = "stage-cost", inline(never))]
fn measure(tets: &[Tet], state: &mut State) {
    #[cfg(not(target_os = "none"))]
    let tets = {
        let (fours, rest) = tets.as_chunks::<4>();
        for (group, shapes) in fours.iter().zip(state.shapes.iter_mut()) {
            if !in_range(group, state.nodes) {
                return;
            }
            let (gradients, six_volume) = gradients(state.nodes, group);
            *shapes = TetShapes { gradients, six_volume };
            gather_volume(group, six_volume, state.nodes);
        }
        rest
    };
    for tet in tets.as_chunks::<1>().0 {
        if !in_range(tet, state.nodes) {
            return;
        }
        let (_, six_volume) = gradients::<f32, 1>(state.nodes, tet);
        gather_volume(tet, six_volume, state.nodes);
    }
}

#[inline(always)]
fn gather_volume<L: Lanes<W>, const W: usize>(group: &[Tet; W], six_volume: L, nodes: &mut [Node]) {
    for (tet, v) in group.iter().zip(six_volume.to_array()) {
        for n in &tet.node {
            if let Some(node) = nodes.get_mut(usize::from(*n)) {
                node.p += v;
            }
        }
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

/// Pushes every tet's nodes along its volume gradients.
#[cfg_attr(feature = "stage-cost", inline(never))]
fn push<const BARRIER: bool>(tets: &[Tet], state: &mut State) {
    #[cfg(not(target_os = "none"))]
    let tets = {
        let (fours, rest) = tets.as_chunks::<4>();
        for (group, shapes) in fours.iter().zip(state.shapes.iter()) {
            if !in_range(group, state.nodes) {
                return;
            }
            push_group::<_, 4, BARRIER>(group, shapes.gradients, shapes.six_volume, state.nodes);
        }
        rest
    };
    for tet in tets.as_chunks::<1>().0 {
        if !in_range(tet, state.nodes) {
            return;
        }
        let (gradients, six_volume) = gradients::<f32, 1>(state.nodes, tet);
        push_group::<_, 1, BARRIER>(tet, gradients, six_volume, state.nodes);
    }
}

#[inline(always)]
fn push_group<L: Lanes<W>, const W: usize, const BARRIER: bool>(
    group: &[Tet; W],
    [g1, g2, g3]: [Vector3<L>; 3],
    six_volume: L,
    nodes: &mut [Node],
) {
    let at = |corner: usize| L::from_array(group.each_ref().map(|t| node(nodes, t.node[corner]).p));
    let nodal = (at(0) + at(1)) + (at(2) + at(3));
    let j = six_volume * L::from_array(group.each_ref().map(|t| t.six_volume_reciprocal));
    let bulk = L::from_array(group.each_ref().map(|t| t.bulk));
    // closing is positive
    let mut p = nodal + bulk * (j - L::splat(1.0));
    if BARRIER {
        p -= compensation::of_tet(j, L::from_array(group.each_ref().map(|t| t.barrier)));
    }
    let (f1, f2, f3) = (g1.map(|g| p * g), g2.map(|g| p * g), g3.map(|g| p * g));
    let f0 = Vector3::new(-((f1.x + f2.x) + f3.x), -((f1.y + f2.y) + f3.y), -((f1.z + f2.z) + f3.z));
    let rows = [f0, f1, f2, f3].map(L::to_rows);
    // tet by tet, at every width: tets of one group may share a node, and the order of additions is
    // the patch's
    for (lane, tet) in group.iter().enumerate() {
        for (n, row) in tet.node.iter().zip(&rows) {
            if let Some(node) = nodes.get_mut(usize::from(*n)) {
                subtract(&mut node.f, &row[lane]);
            }
        }
    }
}

/// Always true for a checked model; said once per tet, it spares the optimiser a check at every
/// access.
#[inline(always)]
fn in_range<const W: usize>(group: &[Tet; W], nodes: &[Node]) -> bool {
    group.iter().flat_map(|tet| &tet.node).all(|&n| usize::from(n) < nodes.len())
}

/// Gradients of six times the volume with respect to corners b, c, d [m^2], and six times the
/// volume [m^3].
#[inline(always)]
fn gradients<L: Lanes<W>, const W: usize>(nodes: &[Node], group: &[Tet; W]) -> ([Vector3<L>; 3], L) {
    let at = |corner: usize| L::from_rows(group.each_ref().map(|t| node(nodes, t.node[corner]).x));
    let a = at(0);
    let (e1, e2, e3) = (at(1) - a, at(2) - a, at(3) - a);
    let (g1, g2, g3) = (cross(e2, e3), cross(e3, e1), cross(e1, e2));
    let v = e1.x * g1.x + e1.y * g1.y + e1.z * g1.z;
    ([g1, g2, g3], v)
}

#[inline(always)]
fn cross<L: Lanes<W>, const W: usize>(a: Vector3<L>, b: Vector3<L>) -> Vector3<L> {
    Vector3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::row;

    #[test]
    fn one_tet_and_four_at_a_time_give_the_same_bits_where_tets_share_nodes() {
        let mut seed = 7_u32;
        let mut next = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / 16_777_216.0
        };
        let mut nodes = [Node::ZERO; 6];
        for n in &mut nodes {
            n.x = row(Vector3::new(next(), next(), next()));
            n.p = next() - 0.5;
        }
        // four tets that use every corner of the others, in other places; some inverted, so that
        // the barrier acts
        let tets = [[0, 1, 2, 3], [3, 2, 1, 4], [1, 5, 0, 2], [4, 0, 5, 3]].map(|node| Tet {
            node,
            six_volume_reciprocal: 1.0 + next(),
            bulk: next(),
            barrier: next(),
        });
        let (mut four, mut one) = (nodes, nodes);
        let (g, v) = gradients::<wide::f32x4, 4>(&nodes, &tets);
        push_group::<_, 4, true>(&tets, g, v, &mut four);
        for tet in tets.as_chunks::<1>().0 {
            let (g, v) = gradients::<f32, 1>(&nodes, tet);
            push_group::<_, 1, true>(tet, g, v, &mut one);
        }
        for (n, (a, b)) in four.iter().zip(&one).enumerate() {
            assert_eq!(a.f.map(f32::to_bits), b.f.map(f32::to_bits), "node {n}");
        }
    }
}
