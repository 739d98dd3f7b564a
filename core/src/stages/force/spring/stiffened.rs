//! Springs of tissue that stiffens: their energy, and their force times the mean factor of both
//! ends.
//!
//! The energy of every spring must be known before the first force, but nothing has to be computed
//! twice: together with the energy, the force that the spring would have without stiffening is
//! computed and kept in the memory that the volume stage uses later.

use nalgebra::Vector3;

use super::groups::{along, ends};
use crate::lanes::{Lanes, add, subtract};
use crate::model::{Model, Spring};
use crate::params::Tuned;
use crate::state::{Node, State, TetShapes};

/// Number of groups of four springs whose forces fit into one [`TetShapes`].
const KEPT: usize = 3;

/// Half of the energy of a spring over E [m^3], which is the share of each end: `k (l - l0)^2 / 4`,
/// plus `chi k (l - onset l0)^2 / 4` where compensation acts. Also the spring's force over E
/// without stiffening [N/Pa], as in `spring`.
#[inline(always)]
fn stretched<L: Lanes<W>, const W: usize, const COMPENSATED: bool>(
    d: Vector3<L>,
    k: L,
    k_rest: L,
    tuned: &Tuned,
) -> (L, Vector3<L>) {
    let square = d.x * d.x + d.y * d.y + d.z * d.z;
    let stretch = k_rest / square.root();
    let mut q = k - stretch;
    let mut sum = q * q;
    if COMPENSATED {
        let squeezed = (k - L::splat(tuned.onset) * stretch).negative_part();
        let more = L::splat(tuned.compensation) * squeezed;
        sum += more * squeezed;
        q += more;
    }
    let half = sum * (square * (L::splat(0.25) / k));
    (half, d.map(|d| d * q))
}

/// Adds half of the energy of every spring to `node.p` of both ends and keeps the forces for
/// [`pull`], as far as there is memory.
#[inline(always)]
pub(super) fn store<const COMPENSATED: bool>(model: &Model, tuned: &Tuned, state: &mut State) {
    let (fours, rest) = model.springs.as_chunks::<4>();
    let (kept, others) = split(fours, state.shapes);
    for (groups, shapes) in kept.iter().zip(state.shapes.iter_mut()) {
        for (group, force) in groups.iter().zip(&mut shapes.gradients) {
            let Some(pulled) = store_group::<_, 4, COMPENSATED>(group, tuned, state.nodes) else { return };
            *force = pulled;
        }
    }
    for group in others {
        store_group::<wide::f32x4, 4, COMPENSATED>(group, tuned, state.nodes);
    }
    for single in rest.as_chunks::<1>().0 {
        store_group::<f32, 1, COMPENSATED>(single, tuned, state.nodes);
    }
}

/// Adds the force of every spring times the mean factor of its ends; half of each factor is in
/// `node.p`. Call this after [`store`], with the nodes unmoved.
#[inline(always)]
pub(super) fn pull<const COMPENSATED: bool>(model: &Model, tuned: &Tuned, state: &mut State) {
    let (fours, rest) = model.springs.as_chunks::<4>();
    let (kept, others) = split(fours, state.shapes);
    for (groups, shapes) in kept.iter().zip(state.shapes.iter()) {
        for (group, force) in groups.iter().zip(&shapes.gradients) {
            let Some(ends) = ends(group, state.nodes) else { return };
            pull_group(ends, *force, state.nodes);
        }
    }
    for group in others {
        pull_anew::<wide::f32x4, 4, COMPENSATED>(group, tuned, state.nodes);
    }
    for single in rest.as_chunks::<1>().0 {
        pull_anew::<f32, 1, COMPENSATED>(single, tuned, state.nodes);
    }
}

/// Groups whose forces are kept, and the others.
#[inline(always)]
fn split<'a>(fours: &'a [[Spring; 4]], shapes: &[TetShapes]) -> (&'a [[[Spring; 4]; KEPT]], &'a [[Spring; 4]]) {
    let kept = (fours.len() / KEPT).min(shapes.len());
    let (kept, others) = fours.split_at(KEPT * kept);
    (kept.as_chunks().0, others)
}

#[inline(always)]
fn store_group<L: Lanes<W>, const W: usize, const COMPENSATED: bool>(
    group: &[Spring; W],
    tuned: &Tuned,
    nodes: &mut [Node],
) -> Option<Vector3<L>> {
    let ends = ends(group, nodes)?;
    let (half, force) = of_group::<L, W, COMPENSATED>(group, ends, tuned, nodes);
    for (ends, half) in ends.into_iter().zip(half.to_array()) {
        for n in ends {
            if let Some(node) = nodes.get_mut(n) {
                node.p += half;
            }
        }
    }
    Some(force)
}

#[inline(always)]
fn of_group<L: Lanes<W>, const W: usize, const COMPENSATED: bool>(
    group: &[Spring; W],
    ends: [[usize; 2]; W],
    tuned: &Tuned,
    nodes: &[Node],
) -> (L, Vector3<L>) {
    let along = along(ends, nodes);
    let k = L::from_array(group.each_ref().map(|s| s.k));
    let k_rest = L::from_array(group.each_ref().map(|s| s.k_rest));
    stretched::<L, W, COMPENSATED>(L::from_rows(along), k, k_rest, tuned)
}

#[inline(always)]
fn pull_group<L: Lanes<W>, const W: usize>(ends: [[usize; 2]; W], force: Vector3<L>, nodes: &mut [Node]) {
    let half = |n: usize| nodes.get(n).map_or(0.0, |node| node.p);
    let mut factor = [0.0; W];
    for (factor, [i, j]) in factor.iter_mut().zip(ends) {
        *factor = half(i) + half(j);
    }
    let factor = L::from_array(factor);
    for ([i, j], f) in ends.into_iter().zip(L::to_rows(force.map(|f| f * factor))) {
        if let Some(node) = nodes.get_mut(i) {
            add(&mut node.f, &f);
        }
        if let Some(node) = nodes.get_mut(j) {
            subtract(&mut node.f, &f);
        }
    }
}

#[inline(always)]
fn pull_anew<L: Lanes<W>, const W: usize, const COMPENSATED: bool>(group: &[Spring; W], tuned: &Tuned, nodes: &mut [Node]) {
    if let Some(ends) = ends(group, nodes) {
        let (_, force) = of_group::<L, W, COMPENSATED>(group, ends, tuned, nodes);
        pull_group(ends, force, nodes);
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec;

    use super::*;
    use crate::lanes::row;
    use crate::{NodeStep, PatchFile};

    #[repr(C, align(4))]
    struct Words<B: ?Sized>(B);
    static BYTES: &Words<[u8]> = &Words(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/block-m4f-168.patch")));

    /// Forces of a deformed patch [N/Pa], if there is memory for the forces of 12 times `memory`
    /// springs.
    fn forces(memory: usize) -> vec::Vec<crate::lanes::Row> {
        let PatchFile { model, mut params, .. } = PatchFile::open(&BYTES.0).unwrap();
        params.stiffening_b = 5.0;
        let mut node_step = vec![NodeStep::ZERO; model.nodes.len()];
        let tuned = params.build(&model, &mut node_step).unwrap();
        let (mut nodes, mut candidates) = (vec![Node::ZERO; model.nodes.len()], vec![0; model.triangles.len()]);
        let mut shapes = vec![TetShapes::ZERO; TetShapes::count(&model)];
        let mut state = State::new(&model, &mut nodes, &mut candidates, &mut shapes).unwrap();
        let all = core::mem::take(&mut state.shapes);
        state.shapes = &mut all[..memory];
        for (n, node) in state.nodes.iter_mut().enumerate() {
            let x = node.position_m();
            node.x = row(x + Vector3::new(x.y, x.z, x.x) * 0.1);
            // half of a factor, as `stiffen` would leave it, but different at every node
            node.p = 0.5 + 0.01 * n as f32;
        }
        let halves: vec::Vec<f32> = state.nodes.iter().map(|node| node.p).collect();
        store::<true>(&model, &tuned, &mut state);
        for (node, half) in state.nodes.iter_mut().zip(halves) {
            node.p = half;
        }
        pull::<true>(&model, &tuned, &mut state);
        state.nodes.iter().map(|node| node.f).collect()
    }

    #[test]
    fn forces_kept_and_computed_anew_have_the_same_bits() {
        let anew = forces(0);
        assert!(anew.iter().any(|f| f[0] != 0.0));
        for memory in [1, 7, 20] {
            assert_eq!(forces(memory), anew, "{memory}");
        }
    }
}
