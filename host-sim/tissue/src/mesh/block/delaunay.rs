//! Delaunay tetrahedra of points in a closed box (Bowyer 1981, Watson 1981) with exact predicates.
//!
//! The eight box corners come first, so every later point falls inside the hull and needs no
//! enclosing tet. A point exactly on a box face splits the hull triangles it lies on; no flat tet
//! is ever made.

use super::vector::Vec3;
use robust::{Coord3D, insphere, orient3d};

const OUTSIDE: u32 = u32::MAX;

/// The Delaunay tets, positively oriented, of `points`, or `None` if two points coincide or one is
/// outside the box. `points[0..8]` are the box corners: bit 0, 1, 2 of the index chooses the high
/// side of x, y, z.
pub(super) fn delaunay(points: &[Vec3]) -> Option<Vec<[u32; 4]>> {
    let mut triangulation = Triangulation::of_box(points);
    for p in 8..u32::try_from(points.len()).ok()? {
        triangulation.insert(p)?;
    }
    let Triangulation { mut tets, mut free, .. } = triangulation;
    free.sort_unstable();
    for slot in free.into_iter().rev() {
        tets.swap_remove(slot as usize);
    }
    Some(tets)
}

struct Triangulation<'a> {
    points: &'a [Vec3],
    tets: Vec<[u32; 4]>,
    /// Neighbour across the face opposite each corner, shape [tets][4]; `OUTSIDE` on the hull.
    neighbours: Vec<[u32; 4]>,
    /// Result of the test against point p in the current insertion, shape [tets]: `2 p` if the tet
    /// conflicts with p, `2 p + 1` if it does not.
    verdict: Vec<u32>,
    /// Slots of removed tets.
    free: Vec<u32>,
    /// The newest tet, where the next search starts.
    last: u32,
    cavity: Vec<u32>,
    /// Faces of new tets whose neighbour is not there yet: the edge opposite the new point, the
    /// tet, and the corner opposite the face.
    open: Vec<([u32; 2], u32, usize)>,
}

impl<'a> Triangulation<'a> {
    /// The six tets around the diagonal 0-7; the corners are cospherical, so they are Delaunay.
    fn of_box(points: &'a [Vec3]) -> Self {
        let tets = vec![[0, 1, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 3, 2, 7], [0, 6, 4, 7], [0, 5, 1, 7]];
        let across = |t: usize, corner: usize| {
            let twin = |s: &usize| *s != t && (0..4).all(|k| k == corner || tets[*s].contains(&tets[t][k]));
            (0..6).find(twin).map_or(OUTSIDE, |s| s as u32)
        };
        let neighbours = (0..6).map(|t| std::array::from_fn(|corner| across(t, corner))).collect();
        Self { points, tets, neighbours, verdict: vec![0; 6], free: vec![], last: 0, cavity: vec![], open: vec![] }
    }

    fn at(&self, node: u32) -> Coord3D<f64> {
        let [x, y, z] = self.points[node as usize];
        Coord3D { x, y, z }
    }

    /// Sign of the volume of a tet (a, b, c, d), exact.
    fn volume_sign(&self, [a, b, c, d]: [u32; 4]) -> f64 {
        -orient3d(self.at(a), self.at(b), self.at(c), self.at(d))
    }

    fn circumsphere_holds(&self, tet: u32, p: u32) -> bool {
        let [a, b, c, d] = self.tets[tet as usize];
        insphere(self.at(b), self.at(a), self.at(c), self.at(d), self.at(p)) > 0.0
    }

    /// Finds the tet that contains `p` by a visibility walk: it crosses any face that has `p`
    /// strictly behind it, and ends because the tets are Delaunay.
    fn locate(&self, p: u32) -> Option<u32> {
        let mut tet = self.last;
        for _ in 0..=self.tets.len() {
            let corners = self.tets[tet as usize];
            let behind = |k: &usize| self.volume_sign(with_corner(corners, *k, p)) < 0.0;
            match (0..4).find(behind) {
                None => return Some(tet),
                Some(k) if self.neighbours[tet as usize][k] == OUTSIDE => return None,
                Some(k) => tet = self.neighbours[tet as usize][k],
            }
        }
        None
    }

    fn insert(&mut self, p: u32) -> Option<()> {
        let start = self.locate(p)?;
        if !self.circumsphere_holds(start, p) {
            return None; // p is a corner of the tet that contains it
        }
        self.carve(start, p);
        self.open.clear();
        let cavity = std::mem::take(&mut self.cavity);
        for &tet in &cavity {
            for corner in 0..4 {
                self.close_face(tet, corner, p);
            }
        }
        self.free.extend_from_slice(&cavity);
        self.cavity = cavity;
        Some(())
    }

    /// Collects the tets whose circumsphere contains `p`: a face-connected set around `start`.
    fn carve(&mut self, start: u32, p: u32) {
        self.cavity.clear();
        self.cavity.push(start);
        self.verdict[start as usize] = 2 * p;
        let mut next = 0;
        while let Some(&tet) = self.cavity.get(next) {
            next += 1;
            for other in self.neighbours[tet as usize] {
                if other == OUTSIDE || self.verdict[other as usize] >= 2 * p {
                    continue;
                }
                let conflict = self.circumsphere_holds(other, p);
                self.verdict[other as usize] = 2 * p + u32::from(!conflict);
                if conflict {
                    self.cavity.push(other);
                }
            }
        }
    }

    /// Joins `p` to the face opposite `corner` of a cavity tet if that face bounds the cavity.
    fn close_face(&mut self, tet: u32, corner: usize, p: u32) {
        let beyond = self.neighbours[tet as usize][corner];
        let corners = with_corner(self.tets[tet as usize], corner, p);
        if beyond == OUTSIDE {
            if self.volume_sign(corners) == 0.0 {
                return; // p lies on this hull face and splits it
            }
        } else if self.verdict[beyond as usize] == 2 * p {
            return;
        }
        // `insert` frees the cavity's slots only when all its faces are closed, so none of them is
        // reused here.
        let new = self.free.pop().unwrap_or_else(|| {
            self.tets.push([0; 4]);
            self.neighbours.push([OUTSIDE; 4]);
            self.verdict.push(0);
            self.tets.len() as u32 - 1
        });
        self.last = new;
        self.tets[new as usize] = corners;
        self.verdict[new as usize] = 2 * p + 1;
        self.neighbours[new as usize] = [OUTSIDE; 4];
        self.neighbours[new as usize][corner] = beyond;
        if beyond != OUTSIDE {
            let back = self.neighbours[beyond as usize].iter_mut().find(|n| **n == tet);
            back.into_iter().for_each(|n| *n = new);
        }
        for side in (0..4).filter(|k| *k != corner) {
            self.pair(new, side, away_from(corners, side, corner));
        }
    }

    fn pair(&mut self, tet: u32, side: usize, edge: [u32; 2]) {
        if let Some(k) = self.open.iter().position(|o| o.0 == edge) {
            let (_, twin, twin_side) = self.open.swap_remove(k);
            self.neighbours[tet as usize][side] = twin;
            self.neighbours[twin as usize][twin_side] = tet;
        } else {
            self.open.push((edge, tet, side));
        }
    }
}

fn with_corner(mut tet: [u32; 4], corner: usize, node: u32) -> [u32; 4] {
    tet[corner] = node;
    tet
}

/// The two nodes of a tet other than those at corners `i` and `j`, the smaller first.
fn away_from(tet: [u32; 4], i: usize, j: usize) -> [u32; 2] {
    let mut rest = (0..4).filter(|k| *k != i && *k != j).map(|k| tet[k]);
    let (a, b) = (rest.next().unwrap_or(0), rest.next().unwrap_or(0));
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::block::vector::{cross, dot, sub};

    fn corners() -> Vec<Vec3> {
        (0..8).map(|i| [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)]).collect()
    }

    /// A 5 x 5 x 5 lattice: every face, edge and cell is degenerate (coplanar and cospherical).
    fn lattice() -> Vec<Vec3> {
        let mut points = corners();
        for i in 0..125 {
            let p = [i % 5, i / 5 % 5, i / 25].map(|k| f64::from(k) / 4.0);
            if !points.contains(&p) {
                points.push(p);
            }
        }
        points
    }

    fn six_volume(points: &[Vec3], tet: [u32; 4]) -> f64 {
        let [a, b, c, d] = tet.map(|n| points[n as usize]);
        dot(cross(sub(b, a), sub(c, a)), sub(d, a))
    }

    #[test]
    fn degenerate_lattice_fills_the_box_without_flat_tets() {
        let points = lattice();
        let tets = delaunay(&points).unwrap();
        assert!(tets.iter().all(|t| six_volume(&points, *t) > 0.0));
        // Lattice coordinates are multiples of 1/4: the sum is exact.
        assert_eq!(tets.iter().map(|t| six_volume(&points, *t)).sum::<f64>(), 6.0);
    }

    #[test]
    fn no_circumsphere_holds_a_point() {
        let mut points = lattice();
        for (i, p) in points.iter_mut().enumerate().skip(8) {
            for (k, x) in p.iter_mut().enumerate() {
                if *x > 0.0 && *x < 1.0 {
                    *x += 0.02 * (((i * 37 + k * 11) % 17) as f64 / 17.0 - 0.5);
                }
            }
        }
        let tets = delaunay(&points).unwrap();
        let at = |n: u32| Coord3D { x: points[n as usize][0], y: points[n as usize][1], z: points[n as usize][2] };
        for t in tets {
            let [a, b, c, d] = t.map(at);
            assert!((0..points.len() as u32).all(|p| insphere(b, a, c, d, at(p)) <= 0.0));
        }
    }

    #[test]
    fn coincident_and_outside_points_are_refused() {
        for bad in [[0.5, 0.5, 0.5], [1.0, 1.0, 0.0], [0.5, 0.5, 1.5]] {
            let mut points = corners();
            points.extend([[0.5, 0.5, 0.5], bad]);
            assert!(delaunay(&points).is_none());
        }
    }
}
