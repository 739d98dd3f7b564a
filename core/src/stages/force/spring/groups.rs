//! Springs several at a time, whatever nodes they join: for processors with wide registers.

use super::force_per_length;
use crate::lanes::{Lanes, add, difference, scaled, subtract};
use crate::model::Spring;
use crate::params::Tuned;
use crate::state::{Node, node};

/// Adds the forces of `W` springs at a time; if `STIFFENED`, each is stiffened by the factors of
/// its ends, half of each of which is in `node.p`.
#[inline(always)]
pub(super) fn by_groups<L: Lanes<W>, const W: usize, const COMPENSATED: bool, const STIFFENED: bool>(
    groups: &[[Spring; W]],
    tuned: &Tuned,
    nodes: &mut [Node],
) {
    for group in groups {
        // always true for a checked model; asserted once, it saves a check at every access
        if !group.iter().flat_map(|s| [s.i, s.j]).all(|n| usize::from(n) < nodes.len()) {
            return;
        }
        let along = group.each_ref().map(|s| difference(&node(nodes, s.j).x, &node(nodes, s.i).x));
        let d = L::from_rows(along);
        let k = L::from_array(group.each_ref().map(|s| s.k));
        let k_rest = L::from_array(group.each_ref().map(|s| s.k_rest));
        let plain = force_per_length::<L, W, COMPENSATED>(d, k, k_rest, tuned);
        let q = match STIFFENED {
            true => plain * L::from_array(group.each_ref().map(|s| node(nodes, s.i).p + node(nodes, s.j).p)),
            false => plain,
        };
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
