//! Checks that the tets of a solid fit together: at most two on a face, on opposite sides of it,
//! and all in one piece.

use super::error::{Defect, MeshError};
use super::solid::Solid;
use super::surface::{FaceSide, face_sides};

/// Checks a solid whose tets are positively oriented. Orienting the tets hides that a node was
/// pulled through its surroundings, but then there is a face with both tets on one side.
pub(super) fn check(solid: &Solid) -> Result<(), MeshError> {
    let sides = face_sides(&solid.mesh.tets);
    let mut parts = Parts::new(solid.mesh.tets.len());
    for face in sides.chunk_by(|a, b| a.key == b.key) {
        match face {
            [] | [_] => {}
            [a, b] if is_even(a.corners) == is_even(b.corners) => return Err(folded(solid, a, b)),
            [a, b] => parts.join(a.tet, b.tet),
            [.., last] => return Err(crowded(solid, last, face.len())),
        }
    }
    one_piece(solid, &mut parts)
}

/// Whether the corners are an even permutation of their rising order. The two sides of a face list
/// its corners in opposite directions, so that one is even and the other odd.
fn is_even([a, b, c]: [u32; 3]) -> bool {
    (a < b) ^ (b < c) ^ (a < c)
}

fn folded(solid: &Solid, a: &FaceSide, b: &FaceSide) -> MeshError {
    let (tet, first) = (solid.tet(b.tet), solid.tet(a.tet));
    // both are parts of one element
    let defect = if tet.number == first.number {
        Defect::FoldedElement { element: tet.number }
    } else {
        Defect::FoldedFace { tet: tet.number, first: first.number, first_line: first.line }
    };
    solid.error_at_tet(b.tet, defect)
}

fn crowded(solid: &Solid, last: &FaceSide, tets: usize) -> MeshError {
    let defect = Defect::CrowdedFace {
        tet: solid.tet(last.tet).number,
        face: last.key.map(|node| solid.node(node as usize).number),
        tets,
    };
    solid.error_at_tet(last.tet, defect)
}

/// Checks that the tets form one piece. A shared face joins two tets into one piece; a shared node
/// or edge does not, since it is a hinge about which springs allow free rotation.
fn one_piece(solid: &Solid, parts: &mut Parts) -> Result<(), MeshError> {
    let mut found = parts.sizes();
    if found.len() < 2 {
        return Ok(());
    }
    found.sort_unstable_by_key(|&(first, size)| (std::cmp::Reverse(size), first));
    let largest: Vec<_> = found.iter().take(4).map(|(_, n)| n.to_string()).collect();
    let more = if found.len() > largest.len() { ", ..." } else { "" };
    let smallest = found.last().map_or(0, |&(first, _)| first);
    Err(solid.error_at_tet(
        smallest,
        Defect::Parts {
            parts: found.len(),
            sizes: format!("{}{more} tets", largest.join(", ")),
            tet: solid.tet(smallest).number,
        },
    ))
}

/// Disjoint sets of tets; the lowest index represents its set.
struct Parts {
    parent: Vec<usize>,
}

impl Parts {
    fn new(tets: usize) -> Self {
        Self { parent: (0..tets).collect() }
    }

    fn first(&mut self, mut tet: usize) -> usize {
        while self.parent[tet] != tet {
            self.parent[tet] = self.parent[self.parent[tet]];
            tet = self.parent[tet];
        }
        tet
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first(a), self.first(b));
        self.parent[a.max(b)] = a.min(b);
    }

    /// First tet and number of tets of every set, in rising order.
    fn sizes(&mut self) -> Vec<(usize, usize)> {
        let mut size = vec![0; self.parent.len()];
        for tet in 0..self.parent.len() {
            size[self.first(tet)] += 1;
        }
        size.into_iter().enumerate().filter(|&(_, n)| n > 0).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_stands_under_its_first_tet_whatever_the_order_of_joining() {
        for joins in [[(4, 5), (1, 4), (0, 2)], [(1, 5), (2, 0), (5, 4)]] {
            let mut parts = Parts::new(6);
            for (a, b) in joins {
                parts.join(a, b);
            }
            assert_eq!(parts.sizes(), [(0, 2), (1, 3), (3, 1)]);
        }
    }
}
