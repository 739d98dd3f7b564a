//! Springs of tissue that stiffens: their energy, and their force times the factors of both ends.

use nalgebra::Vector3;

use super::groups::by_groups;
use crate::lanes::{Lanes, difference};
use crate::model::{Model, Spring};
use crate::params::Tuned;
use crate::state::{Node, node};

/// Half the energy of a spring over E [m^3], each end's share: `k (l - l0)^2 / 4`, with
/// compensation `chi k (l - onset l0)^2 / 4` more where that acts.
#[inline(always)]
fn half_energy<L: Lanes<W>, const W: usize, const COMPENSATED: bool>(d: Vector3<L>, k: L, k_rest: L, tuned: &Tuned) -> L {
    let square = d.x * d.x + d.y * d.y + d.z * d.z;
    let length = square.root();
    // one division for both quotients, l0 / l and l / k
    let reciprocal = L::splat(1.0) / (length * k);
    let stretch = k_rest * (k * reciprocal);
    let q = k - stretch;
    let mut sum = q * q;
    if COMPENSATED {
        let squeezed = (k - L::splat(tuned.onset) * stretch).negative_part();
        sum += L::splat(tuned.compensation) * (squeezed * squeezed);
    }
    L::splat(0.25) * (sum * (square * (length * reciprocal)))
}

#[inline(always)]
pub(super) fn run<const COMPENSATED: bool>(model: &Model, tuned: &Tuned, nodes: &mut [Node]) {
    let (fours, rest) = model.springs.as_chunks::<4>();
    by_groups::<wide::f32x4, 4, COMPENSATED, true>(fours, tuned, nodes);
    by_groups::<f32, 1, COMPENSATED, true>(rest.as_chunks().0, tuned, nodes);
}

#[inline(always)]
pub(super) fn store<const COMPENSATED: bool>(model: &Model, tuned: &Tuned, nodes: &mut [Node]) {
    let (fours, rest) = model.springs.as_chunks::<4>();
    store_groups::<wide::f32x4, 4, COMPENSATED>(fours, tuned, nodes);
    store_groups::<f32, 1, COMPENSATED>(rest.as_chunks().0, tuned, nodes);
}

#[inline(always)]
fn store_groups<L: Lanes<W>, const W: usize, const COMPENSATED: bool>(groups: &[[Spring; W]], tuned: &Tuned, nodes: &mut [Node]) {
    for group in groups {
        if !group.iter().flat_map(|s| [s.i, s.j]).all(|n| usize::from(n) < nodes.len()) {
            return;
        }
        let along = group.each_ref().map(|s| difference(&node(nodes, s.j).x, &node(nodes, s.i).x));
        let k = L::from_array(group.each_ref().map(|s| s.k));
        let k_rest = L::from_array(group.each_ref().map(|s| s.k_rest));
        let half = half_energy::<L, W, COMPENSATED>(L::from_rows(along), k, k_rest, tuned);
        for (s, half) in group.iter().zip(half.to_array()) {
            for n in [s.i, s.j] {
                if let Some(node) = nodes.get_mut(usize::from(n)) {
                    node.p += half;
                }
            }
        }
    }
}
