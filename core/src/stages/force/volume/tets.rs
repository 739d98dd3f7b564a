//! Loops over the tets, one or four at a time, for every processor but those of `force/armv7em.rs`.

use nalgebra::Vector3;

use crate::lanes::{Lanes, subtract};
use crate::model::Tet;
use crate::stages::force::compensation;
#[cfg(not(target_os = "none"))]
use crate::state::TetShapes;
use crate::state::{Node, State, node};

/// Adds up six times the volume of the tets around every node [m^3].
#[cfg_attr(feature = "stage-cost", inline(never))]
pub(super) fn measure<'a>(tets: &'a [Tet], state: &mut State) -> Option<&'a [Tet]> {
    #[cfg(not(target_os = "none"))]
    let singles = {
        let (fours, rest) = tets.as_chunks::<4>();
        for (group, shapes) in fours.iter().zip(state.shapes.iter_mut()) {
            if !in_range(group, state.nodes) {
                return None;
            }
            let (gradients, six_volume) = gradients(state.nodes, group);
            *shapes = TetShapes { gradients, six_volume };
            gather_volume(group, six_volume, state.nodes);
        }
        rest
    };
    #[cfg(target_os = "none")]
    let singles = tets;
    for tet in singles.as_chunks::<1>().0 {
        if !in_range(tet, state.nodes) {
            return None;
        }
        let (_, six_volume) = gradients::<f32, 1>(state.nodes, tet);
        gather_volume(tet, six_volume, state.nodes);
    }
    Some(tets)
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

/// Pushes every tet's nodes along its volume gradients.
#[cfg_attr(feature = "stage-cost", inline(never))]
pub(super) fn push<const BARRIER: bool>(tets: &[Tet], state: &mut State) {
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
    // positive if it pulls the corners together
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

/// Always true for a checked model; tested once per tet, it saves a test at every access.
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
        // four tets that share all corners in different places; some are inverted, so that the
        // barrier acts
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
