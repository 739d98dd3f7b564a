//! Springs along the edges (paper 000, eq 4), with compression compensation and damping fused into the same loop.
//!
//! Per spring, `d = x_j - x_i` and `l = |d|`: `u = k l0 / l`, `q = k - u` (+ compensation), `f_i += q d`, `f_j -= q d`. That is eq 4 written with
//! one square root and one division. The order of additions *at each node* is the patch's order whatever the loop, hence the same bits.
//!
//! * in: positions (velocities, when spring damping is on)
//! * out: adds to `node.f`
//! * cost (M4F, estimated from exact instruction counts): about 90 cycles a spring; `palpate-tests`' `board_cost` prints it
//! * may fail: never; a spring of length zero gives a non-finite force, which `integrate` turns into a fault

use nalgebra::Vector3;

use super::compensation;
use crate::lanes::{Lanes, Row, add, difference, row, scaled, subtract, vector};
use crate::model::{Model, Spring};
use crate::params::Tuned;
use crate::state::{Node, State, node};

/// Adds the spring forces over E [N/Pa].
#[cfg_attr(feature = "stage-cost", inline(never))]
pub fn pull(model: &Model, tuned: &Tuned, state: &mut State) {
    let damped = tuned.spring_damping_s > 0.0;
    match (tuned.terms.compensation, damped) {
        (true, false) => run::<true, false>(model, tuned, state.nodes),
        (false, false) => run::<false, false>(model, tuned, state.nodes),
        (true, true) => run::<true, true>(model, tuned, state.nodes),
        (false, true) => run::<false, true>(model, tuned, state.nodes),
    }
}

#[cfg(target_os = "none")]
#[inline(always)]
fn run<const COMPENSATED: bool, const DAMPED: bool>(model: &Model, tuned: &Tuned, nodes: &mut [Node]) {
    by_rows::<COMPENSATED, DAMPED>(model, tuned, nodes);
}

#[cfg(not(target_os = "none"))]
#[inline(always)]
fn run<const COMPENSATED: bool, const DAMPED: bool>(model: &Model, tuned: &Tuned, nodes: &mut [Node]) {
    let (fours, rest) = model.springs.as_chunks::<4>();
    by_groups::<wide::f32x4, 4, COMPENSATED, DAMPED>(fours, tuned, nodes);
    by_groups::<f32, 1, COMPENSATED, DAMPED>(rest.as_chunks().0, tuned, nodes);
}

/// Springs of one node at a time, that node's sum in registers: least loads and stores, for the board.
#[cfg_attr(not(target_os = "none"), allow(dead_code))] // reason: the desktop runs it in tests only
pub(crate) fn by_rows<const COMPENSATED: bool, const DAMPED: bool>(model: &Model, tuned: &Tuned, nodes: &mut [Node]) {
    let mut springs = model.springs;
    for (i, &count) in model.spring_rows.iter().enumerate() {
        let Some((mine, others)) = springs.split_at_checked(usize::from(count)) else { return };
        springs = others;
        let Some(node) = nodes.get(i) else { return };
        let (xi, vi, mut fi) = (vector(&node.x), vector(&node.v), vector(&node.f));
        for s in mine {
            let Some(other) = nodes.get_mut(usize::from(s.j)) else { return };
            let d = vector(&other.x) - xi;
            let mut q = force_per_length::<f32, 1, COMPENSATED>(d, s.k, s.k_rest, tuned);
            if DAMPED {
                q += damping::<f32, 1>(d, vector(&other.v) - vi, s.k, tuned);
            }
            let f = d * q;
            fi += f;
            other.f = row(vector(&other.f) - f);
        }
        if let Some(node) = nodes.get_mut(i) {
            node.f = row(fi);
        }
    }
}

/// `W` springs at a time, whatever nodes they join.
#[inline(always)]
pub(crate) fn by_groups<L: Lanes<W>, const W: usize, const COMPENSATED: bool, const DAMPED: bool>(
    groups: &[[Spring; W]],
    tuned: &Tuned,
    nodes: &mut [Node],
) {
    for group in groups {
        // always so for a checked model; said once, it spares the optimiser a check at every access
        if !group.iter().flat_map(|s| [s.i, s.j]).all(|n| usize::from(n) < nodes.len()) {
            return;
        }
        let along = group.each_ref().map(|s| between(nodes, s, |n| &n.x));
        let d = L::from_rows(along);
        let k = L::from_array(group.each_ref().map(|s| s.k));
        let k_rest = L::from_array(group.each_ref().map(|s| s.k_rest));
        let mut q = force_per_length::<L, W, COMPENSATED>(d, k, k_rest, tuned);
        if DAMPED {
            let dv = L::from_rows(group.each_ref().map(|s| between(nodes, s, |n| &n.v)));
            q += damping::<L, W>(d, dv, k, tuned);
        }
        for ((s, d), q) in group.iter().zip(&along).zip(q.to_array()) {
            let f = scaled(d, q);
            if let Some(node) = nodes.get_mut(usize::from(s.i)) {
                add(&mut node.f, &f);
            }
            if let Some(node) = nodes.get_mut(usize::from(s.j)) {
                subtract(&mut node.f, &f);
            }
        }
    }
}

#[inline(always)]
fn between(nodes: &[Node], s: &Spring, quantity: impl Fn(&Node) -> &Row) -> Row {
    difference(quantity(node(nodes, s.j)), quantity(node(nodes, s.i)))
}

/// Spring force over E divided by the length [N/Pa/m], positive when it pulls (000 eq 4).
#[inline(always)]
fn force_per_length<L: Lanes<W>, const W: usize, const COMPENSATED: bool>(d: Vector3<L>, k: L, k_rest: L, tuned: &Tuned) -> L {
    let stretch = k_rest / (d.x * d.x + d.y * d.y + d.z * d.z).root();
    let mut q = k - stretch;
    if COMPENSATED {
        q += compensation::of_spring(k, stretch, L::splat(tuned.onset), L::splat(tuned.compensation));
    }
    q
}

/// Damping force over E divided by the length: stiffness-proportional, along the spring (000 eq 5 with d = beta k; eq 12 as printed
/// has the unit kg/(s m) and is not used).
#[inline(always)]
fn damping<L: Lanes<W>, const W: usize>(d: Vector3<L>, dv: Vector3<L>, k: L, tuned: &Tuned) -> L {
    let closing = dv.x * d.x + dv.y * d.y + dv.z * d.z;
    L::splat(tuned.spring_damping_s) * k * closing / (d.x * d.x + d.y * d.y + d.z * d.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Limits, Params};

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
            n.v = row(Vector3::new(next(), next(), next()));
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
            foundation: &[],
            rim_nodes: &[],
            rim_edges: &[],
        };
        let params = Params { spring_damping_s: 1e-4, limits: Limits::HIGHEST, ..Params::default() };
        let tuned = params.derive(&[], &[]);
        let (mut a, mut b) = (nodes, nodes);
        by_rows::<true, true>(&model, &tuned, &mut a);
        by_groups::<wide::f32x4, 4, true, true>(springs.as_chunks().0, &tuned, &mut b);
        by_groups::<f32, 1, true, true>(springs.as_chunks::<4>().1.as_chunks().0, &tuned, &mut b);
        for (n, (a, b)) in a.iter().zip(&b).enumerate() {
            assert_eq!(a.f.map(f32::to_bits), b.f.map(f32::to_bits), "node {n}");
        }
    }
}
