//! Order of springs and tets in a patch. It determines the rounding of the forces, and how well a
//! processor can overlap successive items.

use palpate::{Spring, Tet};

use super::stiffness::RestSpring;

/// Distance in the list within which tets share no node, if the mesh allows it: a processor then
/// does not load a sum that it has only just stored.
const TET_DISTANCE: usize = 6;
/// Distance in the list within which springs share no node on wide processors, if the order at
/// every node allows it.
const SPRING_DISTANCE: usize = 8;

/// Sorts springs into rows by their first node, and returns them with the length of each row. This
/// is the order in a patch file.
pub(super) fn rows(rest: &[RestSpring], nodes: usize) -> (Vec<Spring>, Vec<u16>) {
    let mut counts = vec![0_u16; nodes];
    let mut springs: Vec<Spring> = rest
        .iter()
        .map(|s| {
            let [i, j] = s.nodes.map(|n| n as u16);
            Spring { i, j, k: s.k as f32, k_rest: (s.k * s.length_m) as f32 }
        })
        .collect();
    springs.sort_by_key(|s| (s.i, s.j));
    springs.iter().for_each(|s| counts[usize::from(s.i)] += 1);
    (springs, counts)
}

/// Reorders springs so that neighbours in the list share no node, **with the order at every node
/// kept**: the sums, and so the bits, are the same.
///
/// List scheduling: each place in the list gets a spring that is next at both of its nodes and
/// whose nodes were not used recently.
pub(super) fn schedule(springs: &[Spring]) -> Vec<Spring> {
    let nodes = springs.iter().map(|s| usize::from(s.i.max(s.j)) + 1).max().unwrap_or(0);
    let mut queue: Vec<Vec<usize>> = vec![Vec::new(); nodes];
    for (n, s) in springs.iter().enumerate().rev() {
        queue[usize::from(s.i)].push(n);
        queue[usize::from(s.j)].push(n);
    }
    let next_at_both = |queue: &[Vec<usize>], n: usize| {
        let s = &springs[n];
        queue[usize::from(s.i)].last() == Some(&n) && queue[usize::from(s.j)].last() == Some(&n)
    };
    let mut ready: std::collections::BTreeSet<usize> = (0..springs.len()).filter(|&n| next_at_both(&queue, n)).collect();
    let mut last_used = vec![None; nodes];
    let mut order = Vec::with_capacity(springs.len());
    while !ready.is_empty() {
        let here = order.len();
        let age = |n: usize| {
            let of = |v: u16| last_used[usize::from(v)].map_or(usize::MAX, |at: usize| here - at);
            of(springs[n].i).min(of(springs[n].j))
        };
        // nodes with the longest queues first, since these determine the length of the tail
        let length = |n: usize| queue[usize::from(springs[n].i)].len() + queue[usize::from(springs[n].j)].len();
        let best = ready
            .iter()
            .copied()
            .max_by_key(|&n| (age(n).min(SPRING_DISTANCE), length(n), core::cmp::Reverse(n)))
            .unwrap_or_default();
        ready.remove(&best);
        order.push(springs[best]);
        for v in [springs[best].i, springs[best].j].map(usize::from) {
            queue[v].pop();
            last_used[v] = Some(here);
            if let Some(&n) = queue[v].last()
                && next_at_both(&queue, n)
            {
                ready.insert(n);
            }
        }
    }
    order
}

/// Orders tets so that each shares no node with the few before it. The order is the same for all
/// machines.
pub(super) fn interleave(tets: &[Tet]) -> Vec<Tet> {
    let nodes = tets.iter().flat_map(|t| t.node).max().map_or(0, |n| usize::from(n) + 1);
    let mut last_used: Vec<Option<usize>> = vec![None; nodes];
    let mut left: std::collections::BTreeSet<usize> = (0..tets.len()).collect();
    let mut order = Vec::with_capacity(tets.len());
    while !left.is_empty() {
        let here = order.len();
        let age = |n: usize| {
            let of = |v: u16| last_used[usize::from(v)].map_or(TET_DISTANCE, |at| (here - at).min(TET_DISTANCE));
            tets[n].node.map(of).into_iter().min().unwrap_or(TET_DISTANCE)
        };
        let free = left.iter().copied().find(|&n| age(n) == TET_DISTANCE);
        let best = free.or_else(|| left.iter().copied().max_by_key(|&n| (age(n), core::cmp::Reverse(n)))).unwrap_or_default();
        left.remove(&best);
        tets[best].node.iter().for_each(|&v| last_used[usize::from(v)] = Some(here));
        order.push(tets[best]);
    }
    order
}
