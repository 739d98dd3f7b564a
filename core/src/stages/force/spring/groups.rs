//! Processes several springs at a time, whatever nodes they join, on processors with wide
//! registers.

use super::force_per_length;
use crate::lanes::{Lanes, ROW, Row, add, difference, scaled, subtract};
use crate::model::Spring;
use crate::params::Tuned;
use crate::state::{Node, node};

/// Adds the forces of `W` springs at a time.
#[inline(always)]
pub(super) fn by_groups<L: Lanes<W>, const W: usize, const COMPENSATED: bool>(
    groups: &[[Spring; W]],
    tuned: &Tuned,
    nodes: &mut [Node],
) {
    for group in groups {
        // always true for a checked model; tested once here, it saves a test at every access
        if !group.iter().flat_map(|s| [s.i, s.j]).all(|n| usize::from(n) < nodes.len()) {
            return;
        }
        let along = group.each_ref().map(|s| difference(&node(nodes, s.j).x, &node(nodes, s.i).x));
        let d = L::from_rows(along);
        let k = L::from_array(group.each_ref().map(|s| s.k));
        let k_rest = L::from_array(group.each_ref().map(|s| s.k_rest));
        let q = force_per_length::<L, W, COMPENSATED>(d, k, k_rest, tuned);
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

/// Nodes at both ends of each spring: `Some` for a checked model. Because the indices are checked
/// once here and then passed by value, no access needs a bounds check.
#[inline(always)]
pub(super) fn ends<const W: usize>(group: &[Spring; W], nodes: &[Node]) -> Option<[[usize; 2]; W]> {
    let ends = group.each_ref().map(|s| [usize::from(s.i), usize::from(s.j)]);
    ends.as_flattened().iter().all(|n| *n < nodes.len()).then_some(ends)
}

/// Vector from the first to the second end of each spring [m].
#[inline(always)]
pub(super) fn along<const W: usize>(ends: [[usize; 2]; W], nodes: &[Node]) -> [Row; W] {
    let at = |n: usize| nodes.get(n).map_or([0.0; ROW], |node| node.x);
    let mut along = [[0.0; ROW]; W];
    for (along, [i, j]) in along.iter_mut().zip(ends) {
        *along = difference(&at(j), &at(i));
    }
    along
}
