//! Cuts a lattice tet along the surface: the stencils of isosurface stuffing (Labelle and Shewchuk
//! 2007, section 3), by rule instead of a table.
//!
//! The part of a tet that remains is a tet, a pyramid over a quadrilateral, or a prism. A
//! quadrilateral on a lattice face must be halved alike from both sides: by the diagonal that ends
//! at the cut of the face's long edge or, if that edge is not cut, at its end of even parity. A
//! quadrilateral on the surface is halved by the shorter diagonal if both are possible.

/// Side of the surface on which a corner lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Side {
    In,
    Out,
    /// The corner is on the surface.
    On,
}

/// A corner of a remaining part: a corner of the tet, or the cut on the edge from an inner corner
/// to an outer one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Corner(usize),
    Cut(usize, usize),
}

/// A lattice tet, positively oriented; its edges 01 and 23 are long.
pub(super) struct Cell {
    pub sides: [Side; 4],
    /// Parity of each corner, which differs between the ends of a long edge.
    pub even: [bool; 4],
}

impl Cell {
    /// Positively oriented tets that fill the part inside. `shorter` says whether the first of two
    /// diagonals is at most as long as the second.
    pub fn inside(&self, shorter: impl Fn([Part; 2], [Part; 2]) -> bool) -> Vec<[Part; 4]> {
        use Part::{Corner, Cut};
        let [p, q, r, s] = self.sorted();
        let count = |side| self.sides.iter().filter(|s| **s == side).count();
        match (count(Side::In), count(Side::Out)) {
            (0, _) => Vec::new(),
            (_, 0) => vec![[0, 1, 2, 3].map(Corner)],
            (1, _) => {
                let toward = |k| if self.sides[k] == Side::Out { Cut(p, k) } else { Corner(k) };
                vec![[Corner(p), toward(q), toward(r), toward(s)]]
            }
            (2, 1) => {
                let [a, b, c, d] = [Corner(p), Corner(q), Cut(q, r), Cut(p, r)];
                let halves = if self.halved_at_first(p, q, r) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                halves.map(|[a, b, c]| [a, b, c, Corner(s)]).into()
            }
            (2, _) => {
                let bottom = [Corner(p), Cut(p, r), Cut(p, s)];
                let top = [Corner(q), Cut(q, r), Cut(q, s)];
                let (first, second) = (self.halved_at_first(p, q, r), self.halved_at_first(p, q, s));
                let third = if first == second { shorter([bottom[1], top[2]], [bottom[2], top[1]]) } else { second };
                prism(bottom, top, [first, second, third])
            }
            _ => {
                let before = [(p, q), (p, r), (q, r)].map(|(a, b)| self.halved_at_first(a, b, s));
                prism([p, q, r].map(Corner), [p, q, r].map(|k| Cut(k, s)), before)
            }
        }
    }

    /// Corners in a positive order: first the inner ones, then the outer ones, then those on the
    /// surface.
    fn sorted(&self) -> [usize; 4] {
        let mut order = [0, 1, 2, 3];
        order.sort_by_key(|k| self.sides[*k]);
        let swaps = (0..4).flat_map(|a| (a + 1..4).map(move |b| (a, b))).filter(|(a, b)| order[*a] > order[*b]).count();
        if swaps % 2 == 1 {
            // exchanges two corners on the same side, so that the tet keeps its orientation
            if self.sides[order[1]] == Side::In { order.swap(0, 1) } else { order.swap(2, 3) }
        }
        order
    }

    /// Whether the quadrilateral of the inner corners `a`, `b` and their cuts toward `out` is
    /// halved by the diagonal from `a`, not by that from `b`.
    fn halved_at_first(&self, a: usize, b: usize, out: usize) -> bool {
        let long = |i: usize, j: usize| i / 2 == j / 2;
        if long(b, out) {
            true
        } else if long(a, out) {
            false
        } else {
            self.even[a]
        }
    }
}

/// Tets of a prism with columns `bottom[k]`-`top[k]`. The flags say for the pairs 01, 02, 12 of
/// columns that the diagonal between them starts at the bottom of the first; the three are never
/// cyclic.
fn prism(bottom: [Part; 3], top: [Part; 3], [b01, b02, b12]: [bool; 3]) -> Vec<[Part; 4]> {
    let bottoms = [u8::from(b01) + u8::from(b02), u8::from(!b01) + u8::from(b12), u8::from(!b02) + u8::from(!b12)];
    let mut order = [0, 1, 2];
    order.sort_by_key(|k| 2 - bottoms[*k]);
    let [i, j, k] = order;
    let parts =
        [[bottom[i], bottom[j], bottom[k], top[k]], [bottom[i], bottom[j], top[k], top[j]], [bottom[i], top[i], top[j], top[k]]];
    let turned = (j + 3 - i) % 3 == 2;
    parts.map(|[a, b, c, d]| if turned { [b, a, c, d] } else { [a, b, c, d] }).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    const CORNERS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 1.0, 1.0], [1.0, -1.0, 1.0]];

    fn place(part: Part) -> Vector3<f64> {
        let at = |k: usize| Vector3::from(CORNERS[k]);
        match part {
            Part::Corner(k) => at(k),
            // uneven, so that a wrong cut changes the volume
            Part::Cut(a, b) => at(a) + (at(b) - at(a)) * (0.45 + 0.02 * (a as f64) + 0.01 * (b as f64)),
        }
    }

    fn six_volumes(tet: [Part; 4]) -> f64 {
        let [a, b, c, d] = tet.map(place);
        (b - a).cross(&(c - a)).dot(&(d - a))
    }

    #[test]
    fn every_pattern_is_filled_by_positive_tets_without_a_gap() {
        for pattern in 0..81_usize {
            let sides = [1, 3, 9, 27].map(|d| [Side::In, Side::Out, Side::On][pattern / d % 3]);
            for (parity, first) in (0..4).flat_map(|p| [(p, true), (p, false)]) {
                let even = [parity & 1 == 0, parity & 1 != 0, parity & 2 == 0, parity & 2 != 0];
                let tets = Cell { sides, even }.inside(|_, _| first);
                assert!(tets.iter().all(|t| six_volumes(*t) > 0.0), "{sides:?}");
                let count = |side| sides.iter().filter(|s| **s == side).count();
                let expected = match (count(Side::In), count(Side::Out)) {
                    (0, _) => 0,
                    (_, 0) | (1, _) => 1,
                    (2, 1) => 2,
                    _ => 3,
                };
                assert_eq!(tets.len(), expected, "{sides:?}");
                let at_corner = |face: &[Part; 3], k| {
                    face.iter().any(|p| {
                        matches!(p, Part::Corner(c) | Part::Cut(c, _) if *c == k) || matches!(p, Part::Cut(_, c) if *c == k)
                    })
                };
                for face in open_faces(&tets) {
                    let on_surface = face.iter().all(|p| !matches!(p, Part::Corner(k) if sides[*k] == Side::In));
                    let on_a_face_of_the_cell = (0..4).any(|k| !at_corner(&face, k));
                    assert!(on_surface || on_a_face_of_the_cell, "{sides:?}: gap at {face:?}");
                }
            }
        }
    }

    /// Faces that belong to only one tet.
    fn open_faces(tets: &[[Part; 4]]) -> Vec<[Part; 3]> {
        let mut open: Vec<[Part; 3]> = Vec::new();
        for &[a, b, c, d] in tets {
            for face in [[b, c, d], [a, d, c], [a, b, d], [a, c, b]] {
                match open.iter().position(|other| face.iter().all(|p| other.contains(p))) {
                    Some(twin) => drop(open.swap_remove(twin)),
                    None => open.push(face),
                }
            }
        }
        open
    }
}
