//! Springs along the edges (paper 000, eq 4), with compression compensation fused into the same
//! loop.
//!
//! Per spring, `d = x_j - x_i` and `l = |d|`: `u = k l0 / l`, `q = k - u` (+ compensation), `f_i +=
//! q d`, `f_j -= q d`. That is eq 4 written with one square root and one division. The order of
//! additions *at each node* is the patch's order in every loop, hence the same bits.
//!
//! * in: positions
//! * out: adds to `node.f`
//! * cost (M4F, estimated from exact instruction counts): about 80 cycles per spring; `board_cost`
//!   of `palpate-tests` prints it
//! * failures: none; a spring of length zero gives a non-finite force, which `integrate` turns
//!   into a fault

#[cfg(not(target_os = "none"))]
mod groups;
#[cfg(not(target_os = "none"))]
mod stiffened;

#[cfg(not(armv7em_fp))]
use nalgebra::Vector3;

#[cfg(not(armv7em_fp))]
use super::compensation;
#[cfg(not(armv7em_fp))]
use crate::lanes::{Lanes, row, vector};
use crate::model::Model;
use crate::params::Tuned;
use crate::state::{Node, State};

/// Adds the spring forces over E [N/Pa].
#[cfg_attr(feature = "stage-cost", inline(never))]
pub fn pull(model: &Model, tuned: &Tuned, state: &mut State) {
    match tuned.terms.compensation {
        true => run::<true>(model, tuned, state.nodes),
        false => run::<false>(model, tuned, state.nodes),
    }
}

/// Like [`pull`], with every spring stiffened by the factors of its ends; half of each factor is in
/// `node.p`.
#[cfg(not(target_os = "none"))]
#[cfg_attr(feature = "stage-cost", inline(never))]
pub(super) fn pull_stiffened(model: &Model, tuned: &Tuned, state: &mut State) {
    match tuned.terms.compensation {
        true => stiffened::pull::<true>(model, tuned, state),
        false => stiffened::pull::<false>(model, tuned, state),
    }
}

/// Adds half of the energy of every spring over E to `node.p` of both ends [m^3].
#[cfg(not(target_os = "none"))]
#[cfg_attr(feature = "stage-cost", inline(never))]
pub(super) fn store(model: &Model, tuned: &Tuned, state: &mut State) {
    match tuned.terms.compensation {
        true => stiffened::store::<true>(model, tuned, state),
        false => stiffened::store::<false>(model, tuned, state),
    }
}

#[cfg(armv7em_fp)]
#[inline(always)]
fn run<const COMPENSATED: bool>(model: &Model, tuned: &Tuned, nodes: &mut [Node]) {
    // with this onset no spring is compensated, because none has a negative length
    let onset = if COMPENSATED { tuned.onset } else { 0.0 };
    super::armv7em::springs(model, nodes, onset, tuned.compensation);
}

#[cfg(all(target_os = "none", not(armv7em_fp)))]
#[inline(always)]
fn run<const COMPENSATED: bool>(model: &Model, tuned: &Tuned, nodes: &mut [Node]) {
    by_rows::<COMPENSATED>(model, tuned, nodes);
}

#[cfg(not(target_os = "none"))]
#[inline(always)]
fn run<const COMPENSATED: bool>(model: &Model, tuned: &Tuned, nodes: &mut [Node]) {
    let (fours, rest) = model.springs.as_chunks::<4>();
    groups::by_groups::<wide::f32x4, 4, COMPENSATED>(fours, tuned, nodes);
    groups::by_groups::<f32, 1, COMPENSATED>(rest.as_chunks().0, tuned, nodes);
}

/// Processes the springs node by node, with that node's sum in registers. This needs the fewest
/// loads and stores and is meant for the board.
#[cfg(not(armv7em_fp))]
#[cfg_attr(not(any(target_os = "none", test)), expect(dead_code, reason = "the desktop runs it in tests only"))]
pub(crate) fn by_rows<const COMPENSATED: bool>(model: &Model, tuned: &Tuned, nodes: &mut [Node]) {
    let mut springs = model.springs;
    for (i, &count) in model.spring_rows.iter().enumerate() {
        let Some((mine, others)) = springs.split_at_checked(usize::from(count)) else { return };
        springs = others;
        let Some(node) = nodes.get(i) else { return };
        let (xi, mut fi) = (vector(&node.x), vector(&node.f));
        for s in mine {
            let Some(other) = nodes.get_mut(usize::from(s.j)) else { return };
            let d = vector(&other.x) - xi;
            let f = d * force_per_length::<f32, 1, COMPENSATED>(d, s.k, s.k_rest, tuned);
            fi += f;
            other.f = row(vector(&other.f) - f);
        }
        if let Some(node) = nodes.get_mut(i) {
            node.f = row(fi);
        }
    }
}

/// Spring force over E divided by the length [N/Pa/m], positive when it pulls (000 eq 4).
#[cfg(not(armv7em_fp))]
#[inline(always)]
fn force_per_length<L: Lanes<W>, const W: usize, const COMPENSATED: bool>(d: Vector3<L>, k: L, k_rest: L, tuned: &Tuned) -> L {
    let stretch = k_rest / (d.x * d.x + d.y * d.y + d.z * d.z).root();
    let mut q = k - stretch;
    if COMPENSATED {
        q += compensation::of_spring(k, stretch, L::splat(tuned.onset), L::splat(tuned.compensation));
    }
    q
}

#[cfg(test)]
mod tests {
    use super::groups::by_groups;
    use super::*;
    use crate::model::Spring;
    use crate::{GuardLimits, Params};

    #[test]
    fn rows_and_groups_give_the_same_bits() {
        let mut seed = 1_u32;
        let mut next = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / 16_777_216.0
        };
        let mut nodes = [Node::ZERO; 12];
        for n in &mut nodes {
            n.x = row(Vector3::new(next(), next(), next()));
        }
        let mut springs = [Spring { i: 0, j: 0, k: 0.0, k_rest: 0.0 }; 66];
        let mut rows = [0_u16; 12];
        let mut at = 0;
        for i in 0..12 {
            for j in i + 1..12 {
                let k = 0.5 + next();
                springs[at] = Spring { i, j, k, k_rest: k * (0.3 + next()) };
                rows[usize::from(i)] += 1;
                at += 1;
            }
        }
        let model = Model {
            poisson_ratio: 0.45,
            stiffening_per_m: 1.0,
            depth_limit_m: 1.0,
            nodes: &[],
            anchors: &[],
            spring_rows: &rows,
            springs: &springs,
            tets: &[],
            triangles: &[],
            steepness: &[],
            neighbours: &[],
            owners: &[],
            foundation: &[],
            rim_nodes: &[],
            rim_edges: &[],
            law: None,
        };
        let params = Params { limits: GuardLimits::HIGHEST, ..Params::default() };
        let tuned = params.derive(&mut [], [0.0; 4]);
        let (mut a, mut b) = (nodes, nodes);
        by_rows::<true>(&model, &tuned, &mut a);
        by_groups::<wide::f32x4, 4, true>(springs.as_chunks().0, &tuned, &mut b);
        by_groups::<f32, 1, true>(springs.as_chunks::<4>().1.as_chunks().0, &tuned, &mut b);
        for (n, (a, b)) in a.iter().zip(&b).enumerate() {
            assert_eq!(a.f.map(f32::to_bits), b.f.map(f32::to_bits), "node {n}");
        }
    }
}
