//! Springs several at a time, whatever nodes they join: for processors with wide registers.

use super::{damping, force_per_length};
use crate::lanes::{Lanes, Row, add, difference, scaled, subtract};
use crate::model::Spring;
use crate::params::Tuned;
use crate::state::{Node, node};

/// Adds the forces of `W` springs at a time.
#[inline(always)]
pub(super) fn by_groups<L: Lanes<W>, const W: usize, const COMPENSATED: bool, const DAMPED: bool>(
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
