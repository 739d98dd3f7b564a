//! The boundary triangles and the edges of a tet mesh.

use nalgebra::Vector3;

use super::TetMesh;
use super::pairs::{Wedge, neighbours};

/// Faces of a positively oriented tet, counter-clockwise seen from outside it.
const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// A face as seen from one of its tets.
pub(crate) struct FaceSide {
    /// Nodes of the face in rising order, the same from both sides.
    pub key: [u32; 3],
    pub tet: usize,
    /// Index of the face in the tet: that of the opposite corner.
    pub face: usize,
    /// Nodes of the face, counter-clockwise seen from outside the tet.
    pub corners: [u32; 3],
}

/// The sides of all faces; those of one face follow each other, in the order of their tets.
pub(crate) fn face_sides(tets: &[[u32; 4]]) -> Vec<FaceSide> {
    let mut sides = Vec::with_capacity(4 * tets.len());
    for (tet, nodes) in tets.iter().enumerate() {
        for (face, corners) in FACES.iter().enumerate() {
            let corners = corners.map(|corner| nodes[corner]);
            let mut key = corners;
            key.sort_unstable();
            sides.push(FaceSide { key, tet, face, corners });
        }
    }
    sides.sort_unstable_by_key(|side| (side.key, side.tet, side.face));
    sides
}

/// Boundary triangles, shape `[triangles][3]`: the faces that belong to only one tet, in the order
/// of the tets. They are counter-clockwise seen from outside if every tet is positively oriented.
#[must_use]
pub fn surface(tets: &[[u32; 4]]) -> Vec<[u32; 3]> {
    let sides = face_sides(tets);
    let mut open: Vec<_> = sides
        .chunk_by(|a, b| a.key == b.key)
        .filter_map(|face| match face {
            [side] => Some((side.tet, side.face, side.corners)),
            _ => None,
        })
        .collect();
    open.sort_unstable();
    open.into_iter().map(|(_, _, corners)| corners).collect()
}

/// Number of pieces; two tets are connected if they share a face.
#[must_use]
pub fn pieces(tets: &[[u32; 4]]) -> usize {
    let mut parent: Vec<usize> = (0..tets.len()).collect();
    let mut first = |mut tet: usize, joined: Option<usize>| {
        while parent[tet] != tet {
            parent[tet] = parent[parent[tet]];
            tet = parent[tet];
        }
        if let Some(other) = joined {
            parent[tet] = other;
        }
        tet
    };
    for face in face_sides(tets).chunk_by(|a, b| a.key == b.key) {
        for pair in face.windows(2) {
            let other = first(pair[1].tet, None);
            first(pair[0].tet, Some(other));
        }
    }
    (0..tets.len()).filter(|t| first(*t, None) == *t).count()
}

/// Walls of internal cavities.
pub(super) struct Walls {
    /// Whether each triangle is part of one, shape `[triangles]`.
    pub is_inner: Vec<bool>,
    /// Number of cavities.
    pub hollows: usize,
    /// Whether a wall has a node in common with the skin or another wall.
    pub touch: bool,
}

/// The walls of cavities among the triangles of a closed surface, counter-clockwise seen from
/// outside: the pieces that, by their orientation, enclose a negative volume. Cavities that touch
/// each other or the skin in a node or an edge are apart.
pub(super) fn walls(nodes_m: &[[f64; 3]], triangles: &[[u32; 3]]) -> Walls {
    let none = || Walls { is_inner: vec![false; triangles.len()], hollows: 0, touch: false };
    let Ok(around) = neighbours(nodes_m, triangles, Wedge::Void) else { return none() };
    let mut parent: Vec<usize> = (0..triangles.len()).collect();
    for (n, beyond) in around.iter().enumerate() {
        for other in beyond {
            let (a, b) = (root(&mut parent, n), root(&mut parent, other.triangle as usize));
            parent[a.max(b)] = a.min(b);
        }
    }
    let Some(origin) = triangles.first().map(|t| Vector3::from(nodes_m[t[0] as usize])) else { return none() };
    let mut six_volume_m3 = vec![0.0; triangles.len()];
    for (n, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|n| Vector3::from(nodes_m[n as usize]) - origin);
        six_volume_m3[root(&mut parent, n)] += a.dot(&b.cross(&c));
    }
    let mut piece_at = vec![None; nodes_m.len()];
    let mut touch = false;
    for (n, triangle) in triangles.iter().enumerate() {
        let own = root(&mut parent, n);
        for corner in triangle {
            let first = *piece_at[*corner as usize].get_or_insert(own);
            touch |= first != own && (six_volume_m3[own] < 0.0 || six_volume_m3[first] < 0.0);
        }
    }
    Walls {
        is_inner: (0..triangles.len()).map(|n| six_volume_m3[root(&mut parent, n)] < 0.0).collect(),
        hollows: six_volume_m3.iter().filter(|six| **six < 0.0).count(),
        touch,
    }
}

/// Number of internal cavities of a mesh; `None` if the wall of one has a node in common with the
/// skin or another wall, so that no tissue is left between them.
#[must_use]
pub fn hollows(mesh: &TetMesh) -> Option<usize> {
    let walls = walls(&mesh.nodes_m, &surface(&mesh.tets));
    (!walls.touch).then_some(walls.hollows)
}

/// Whether each node lies on the wall of an internal cavity, shape `[nodes]`.
#[must_use]
pub fn hollow(mesh: &TetMesh) -> Vec<bool> {
    let boundary = surface(&mesh.tets);
    let mut on_wall = vec![false; mesh.nodes_m.len()];
    let walls = walls(&mesh.nodes_m, &boundary);
    for (triangle, _) in boundary.iter().zip(walls.is_inner).filter(|(_, is_inner)| *is_inner) {
        triangle.iter().for_each(|n| on_wall[*n as usize] = true);
    }
    on_wall
}

/// The node that represents all nodes connected to a node.
fn root(parent: &mut [usize], mut node: usize) -> usize {
    while parent[node] != node {
        parent[node] = parent[parent[node]];
        node = parent[node];
    }
    node
}

/// Edges `[i, j]`, `i < j`, each once, in rising order, shape `[edges][2]`.
#[must_use]
pub fn edges(tets: &[[u32; 4]]) -> Vec<[u32; 2]> {
    let mut edges: Vec<_> = tets
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]])
        .map(|[i, j]| if i < j { [i, j] } else { [j, i] })
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block of 5 x 5 x 5 cubes of 1 m without the cubes of `missing`.
    fn cubes(missing: &[[u32; 3]]) -> TetMesh {
        let node = |i: u32, j: u32, k: u32| i + 6 * (j + 6 * k);
        let mut tets = Vec::new();
        for cell in 0..125 {
            let [i, j, k] = [cell % 5, cell / 5 % 5, cell / 25];
            if missing.contains(&[i, j, k]) {
                continue;
            }
            // Kuhn's six tets along the diagonal
            for [a, b] in [[0, 1], [1, 2], [2, 0], [1, 0], [2, 1], [0, 2]] {
                let step = |axes: &[usize]| {
                    let at: [u32; 3] = std::array::from_fn(|k| u32::from(axes.contains(&k)));
                    node(i + at[0], j + at[1], k + at[2])
                };
                let tet = [step(&[]), step(&[a]), step(&[a, b]), step(&[0, 1, 2])];
                let right = (b + 3 - a) % 3 == 1;
                tets.push(if right { tet } else { [tet[0], tet[2], tet[1], tet[3]] });
            }
        }
        let nodes_m = (0..216).map(|n| [n % 6, n / 6 % 6, n / 36].map(f64::from)).collect();
        let regions = vec![0; tets.len()];
        TetMesh { nodes_m, tets, regions }
    }

    #[test]
    fn a_hollow_is_told_from_the_outside_and_from_a_pit() {
        assert!(hollow(&cubes(&[])).iter().all(|on| !on));
        let inside = hollow(&cubes(&[[2, 2, 2]]));
        assert_eq!(inside.iter().filter(|on| **on).count(), 8);
        assert!(inside[2 + 6 * (2 + 6 * 2)] && inside[3 + 6 * (3 + 6 * 3)] && !inside[0]);
        assert!(hollow(&cubes(&[[2, 2, 2], [2, 2, 3], [2, 2, 4]])).iter().all(|on| !on), "a pit is open");
        let rests_on = crate::tissue::underside(&cubes(&[[2, 2, 2]]), [0.0, 0.0, 1.0]);
        assert_eq!(rests_on, (0..36).collect::<Vec<u32>>(), "the roof of a hollow holds nothing");
        assert_eq!(hollow(&cubes(&[[1, 1, 1], [3, 3, 3]])).iter().filter(|on| **on).count(), 16);
    }

    #[test]
    fn hollows_that_touch_in_a_node_are_not_counted() {
        assert_eq!(hollows(&cubes(&[[2, 2, 2]])), Some(1));
        assert_eq!(hollows(&cubes(&[[1, 1, 1], [3, 3, 3]])), Some(2));
        assert_eq!(hollows(&cubes(&[[1, 1, 1], [2, 2, 2]])), None);
        // a notch at the corner of the block meets the hollow in a node
        assert_eq!(hollows(&cubes(&[[0, 0, 0], [1, 1, 1]])), None);
    }

    #[test]
    fn a_lone_tet_shows_its_four_faces_outward() {
        // One face is seen from (1, 1, 1), the others from -x, -y and -z.
        assert_eq!(surface(&[[0, 1, 2, 3]]), [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]);
    }

    #[test]
    fn a_face_between_two_tets_is_not_surface() {
        let triangles = surface(&[[0, 1, 2, 3], [1, 2, 3, 4]]);
        assert_eq!(triangles.len(), 6);
        assert!(triangles.iter().all(|triangle| {
            let mut nodes = *triangle;
            nodes.sort_unstable();
            nodes != [1, 2, 3]
        }));
    }

    #[test]
    fn edges_rise_and_are_unique() {
        assert_eq!(
            edges(&[[3, 1, 2, 0], [4, 3, 2, 1]]),
            [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [1, 4], [2, 3], [2, 4], [3, 4]]
        );
    }

    #[test]
    fn no_tets_have_no_surface_and_no_edges() {
        assert!(surface(&[]).is_empty());
        assert_eq!(pieces(&[]), 0);
    }

    #[test]
    fn a_shared_edge_joins_no_pieces_and_a_shared_face_does() {
        assert_eq!(pieces(&[[0, 1, 2, 3], [2, 3, 4, 5]]), 2);
        assert_eq!(pieces(&[[0, 1, 2, 3], [2, 3, 4, 5], [1, 2, 3, 4]]), 1);
    }

    #[test]
    fn no_tets_have_no_edges() {
        assert!(edges(&[]).is_empty());
    }
}
