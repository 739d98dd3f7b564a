//! Topological flips that improve the worst tet: edge removal (3-2, 4-4, ...; Freitag and
//! Ollivier-Gooch 1997, with the dynamic programme of Klincsek 1980) and its inverse 2-3. Hull
//! faces stay in their planes.

use super::radius_ratio::radius_ratio;
use super::seed::Cloud;
use super::vector::{Vec3, distance};

/// Largest number of tets around an edge that is removed.
const MAX_RING: usize = 9;
/// Factor by which a flip must raise the worst quality (1), so that rounding cannot flip back and
/// forth for ever.
const GAIN: f64 = 1.0 + 1e-6;
/// Quality of a tet that crosses the shell, as a share of its shape quality (1): such tets are
/// removed first.
const CROSSING: f64 = 0.25;
const DEAD: [u32; 4] = [u32::MAX; 4];

/// A tet complex that is edited in place.
pub(super) struct Complex<'a> {
    pub cloud: &'a mut Cloud,
    tets: Vec<[u32; 4]>,
    quality: Vec<f64>,
    /// Tets around each node, oldest first, shape [nodes][tets around it].
    around: Vec<Vec<u32>>,
}

impl<'a> Complex<'a> {
    pub fn new(cloud: &'a mut Cloud, tets: Vec<[u32; 4]>) -> Self {
        let around = vec![vec![]; cloud.at.len()];
        let mut complex = Self { cloud, tets: vec![], quality: vec![], around };
        tets.into_iter().for_each(|t| complex.add(t));
        complex
    }

    pub fn into_tets(self) -> Vec<[u32; 4]> {
        self.tets.into_iter().filter(|t| *t != DEAD).collect()
    }

    /// Quality of the worst tet around `node` if the node were at `there`; an edge shorter than
    /// `short` also lowers a tet's quality.
    pub fn worst_around(&self, node: usize, there: Vec3, short: f64) -> f64 {
        let corner = |n: u32| if n as usize == node { there } else { self.cloud.at[n as usize] };
        let score = |t: &u32| {
            let tet = self.tets[*t as usize];
            let others = tet.into_iter().filter(|n| *n as usize != node);
            let nearest = others.map(|n| distance(there, corner(n))).fold(short, f64::min);
            self.score(tet, corner) * (nearest / short)
        };
        self.around[node].iter().map(score).fold(1.0, f64::min)
    }

    pub fn refresh_around(&mut self, node: usize) {
        for &t in &self.around[node] {
            self.quality[t as usize] = self.quality_of(self.tets[t as usize]);
        }
    }

    /// Flips around every tet worse than `good` until no flip helps; returns whether any did.
    pub fn flip_below(&mut self, good: f64) -> bool {
        let mut flipped = false;
        let mut t = 0;
        while t < self.tets.len() {
            // New tets are appended, so that they are visited too.
            if self.tets[t] != DEAD && self.quality[t] < good {
                flipped |= self.flip_one(self.tets[t]);
            }
            t += 1;
        }
        flipped
    }

    fn quality_of(&self, tet: [u32; 4]) -> f64 {
        self.score(tet, |n| self.cloud.at[n as usize])
    }

    /// Radius ratio, lowered for a tet that lies on both sides of the shell.
    fn score(&self, tet: [u32; 4], at: impl Fn(u32) -> Vec3) -> f64 {
        let shape = radius_ratio(tet.map(at));
        if shape > 0.0 && self.cloud.crosses_shell(tet) { CROSSING * shape } else { shape }
    }

    fn add(&mut self, tet: [u32; 4]) {
        let slot = self.tets.len() as u32;
        self.quality.push(self.quality_of(tet));
        self.tets.push(tet);
        tet.into_iter().for_each(|n| self.around[n as usize].push(slot));
    }

    fn replace(&mut self, old: &[u32], new: &[[u32; 4]]) {
        for &t in old {
            for n in std::mem::replace(&mut self.tets[t as usize], DEAD) {
                self.around[n as usize].retain(|s| *s != t);
            }
        }
        new.iter().for_each(|t| self.add(*t));
    }

    /// Tets that contain all of `nodes`.
    fn star(&self, nodes: &[u32]) -> Vec<u32> {
        let holds = |t: &&u32| nodes.iter().all(|n| self.tets[**t as usize].contains(n));
        self.around[nodes[0] as usize].iter().filter(holds).copied().collect()
    }

    fn worst_of(&self, tets: &[u32]) -> f64 {
        tets.iter().map(|t| self.quality[*t as usize]).fold(1.0, f64::min)
    }

    fn flip_one(&mut self, tet: [u32; 4]) -> bool {
        const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
        EDGES.into_iter().any(|e| self.remove_edge(e.map(|k| tet[k]))) || (0..4).any(|apex| self.remove_face(tet, apex))
    }

    /// 2-3 flip of the face opposite `apex`.
    fn remove_face(&mut self, tet: [u32; 4], apex: usize) -> bool {
        // Even permutations that bring each corner last: (a, b, c) then turns positively around
        // (below, top).
        const LAST: [[usize; 4]; 4] = [[1, 3, 2, 0], [0, 2, 3, 1], [0, 3, 1, 2], [0, 1, 2, 3]];
        let [a, b, c, top] = LAST[apex].map(|k| tet[k]);
        let old = self.star(&[a, b, c]);
        let below = old.iter().flat_map(|t| self.tets[*t as usize]).find(|n| ![a, b, c, top].contains(n));
        let Some(below) = below else { return false };
        let new = [[below, top, a, b], [below, top, b, c], [below, top, c, a]];
        let worst = new.iter().map(|t| self.quality_of(*t)).fold(1.0, f64::min);
        let gains = worst > GAIN * self.worst_of(&old);
        if gains {
            self.replace(&old, &new);
        }
        gains
    }

    /// Removes the edge `a`-`b` and re-triangulates the ring of nodes around it in the best way.
    fn remove_edge(&mut self, [a, b]: [u32; 2]) -> bool {
        let old = self.star(&[a, b]);
        let Some(ring) = self.ring(a, b, &old) else { return false };
        let worst = self.worst_of(&old);
        let (n, floor) = (ring.len(), GAIN * worst);
        // best[i][j]: worst quality in the best triangulation of ring i..=j, and the node that
        // forms a triangle with i and j in it.
        let mut best = [[(1.0_f64, 0_usize); MAX_RING]; MAX_RING];
        for (span, i) in (2..n).flat_map(|span| (0..n - span).map(move |i| (span, i))) {
            let j = i + span;
            best[i][j].0 = f64::NEG_INFINITY;
            for k in i + 1..j {
                let mut q = best[i][k].0.min(best[k][j].0);
                if q > floor && q > best[i][j].0 {
                    for tet in caps([a, b], [ring[i], ring[k], ring[j]]) {
                        q = q.min(self.quality_of(tet));
                    }
                    if q > best[i][j].0 {
                        best[i][j] = (q, k);
                    }
                }
            }
        }
        let gains = best[0][n - 1].0 > floor;
        if gains {
            let (mut new, mut open) = (vec![], vec![(0, n - 1)]);
            while let Some((i, j)) = open.pop() {
                if j > i + 1 {
                    let k = best[i][j].1;
                    new.extend(caps([a, b], [ring[i], ring[k], ring[j]]));
                    open.extend([(i, k), (k, j)]);
                }
            }
            self.replace(&old, &new);
        }
        gains
    }

    /// The nodes around the edge `a`-`b`, in the positive sense of rotation. An open ring, which a
    /// hull edge has, is returned only if both hull faces share a plane.
    fn ring(&self, a: u32, b: u32, star: &[u32]) -> Option<Vec<u32>> {
        let links: Vec<_> = star.iter().map(|t| link(self.tets[*t as usize], a, b)).collect();
        let open_start = links.iter().find(|l| links.iter().all(|m| m[1] != l[0]));
        let first = open_start.or(links.first())?[0];
        let mut ring = vec![first];
        while let Some(l) = links.iter().find(|l| Some(&l[0]) == ring.last()) {
            if l[1] == first {
                break;
            }
            ring.push(l[1]);
        }
        let hull_quad = [a, b, first, *ring.last()?];
        let fits = (3..=MAX_RING).contains(&ring.len());
        (fits && (open_start.is_none() || self.on_one_face(hull_quad))).then_some(ring)
    }

    fn on_one_face(&self, nodes: [u32; 4]) -> bool {
        let [a, rest @ ..] = nodes.map(|n| n as usize);
        (0..3).any(|k| rest.iter().all(|b| self.cloud.share_face(a, *b, k)))
    }
}

/// The two tets that join a ring triangle to both ends of the removed edge.
fn caps([a, b]: [u32; 2], [i, k, j]: [u32; 3]) -> [[u32; 4]; 2] {
    [[i, k, j, b], [k, i, j, a]]
}

/// The other two nodes (c, d) of a tet, ordered so that (a, b, c, d) is positive.
fn link(tet: [u32; 4], a: u32, b: u32) -> [u32; 2] {
    let place = |n: u32| tet.iter().position(|m| *m == n).unwrap_or(0);
    let (i, j) = (place(a), place(b));
    let mut rest = (0..4).filter(|k| *k != i && *k != j);
    let (k, l) = (rest.next().unwrap_or(0), rest.next().unwrap_or(0));
    // Parity of the permutation (i, j, k, l), whose last two ascend.
    let inversions = usize::from(i > j) + [k, l].iter().map(|m| usize::from(i > *m) + usize::from(j > *m)).sum::<usize>();
    if inversions % 2 == 0 { [tet[k], tet[l]] } else { [tet[l], tet[k]] }
}

#[cfg(test)]
mod tests {
    use super::super::seed::Side;
    use super::*;

    /// A cloud with two tets around the long edge 0-1; 2 and 3 lie on the hull to either side of
    /// it, 4 inside.
    fn wedge(pinned: [bool; 3]) -> Cloud {
        let at = vec![[0.0, 0.0, -3.0], [0.0, 0.0, 3.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.9, 0.9, 0.0]];
        Cloud { pinned: vec![pinned; at.len()], side: vec![Side::Outside; at.len()], at }
    }

    const AROUND: [[u32; 4]; 2] = [[0, 1, 2, 4], [0, 1, 4, 3]];

    #[test]
    fn block_edge_is_never_cut_off() {
        let mut cloud = wedge([false; 3]);
        let mut complex = Complex::new(&mut cloud, AROUND.to_vec());
        assert!(!complex.remove_edge([0, 1]));
        assert_eq!(complex.into_tets(), AROUND);
    }

    #[test]
    fn long_edge_within_one_block_face_is_swapped() {
        // The wedge, opened flat: 0, 1, 2, 3 share the face x = 0, which the edge 0-1
        // crosses along its longer diagonal.
        let mut cloud = wedge([true, false, false]);
        cloud.at[2..].clone_from_slice(&[[0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
        let around = [[0, 1, 4, 2], [0, 1, 3, 4]];
        let mut complex = Complex::new(&mut cloud, around.to_vec());
        assert!(complex.remove_edge([0, 1]));
        let tets = complex.into_tets();
        assert_eq!(tets.len(), 2);
        assert!(tets.iter().all(|t| t.contains(&2) && t.contains(&3) && t.contains(&4)));
    }

    #[test]
    fn tall_ring_loses_its_edge_and_flat_pair_loses_its_face() {
        let ring =
            |i: f64| [[1.0, 0.0, 0.0], [-0.5, 0.75_f64.sqrt(), 0.0], [-0.5, -(0.75_f64.sqrt()), 0.0]].map(|p| p.map(|x| x * i));
        for (reach, tall) in [(1.0, 3.0), (3.0, 0.6)] {
            let [a, b, c] = ring(reach);
            let at = vec![[0.0, 0.0, -tall], [0.0, 0.0, tall], a, b, c];
            let mut cloud = Cloud { pinned: vec![[false; 3]; 5], side: vec![Side::Outside; 5], at };
            let three = vec![[0, 1, 2, 3], [0, 1, 3, 4], [0, 1, 4, 2]];
            let two = vec![[2, 3, 4, 1], [3, 2, 4, 0]];
            let (start, end) = if tall > 1.0 { (three, 2) } else { (two, 3) };
            let mut complex = Complex::new(&mut cloud, start);
            assert!(complex.flip_below(1.0));
            assert_eq!(complex.into_tets().len(), end);
        }
    }
}
