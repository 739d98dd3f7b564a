//! The boundary triangles and the edges of a tet mesh.

/// Faces of a positively oriented tet, counter-clockwise seen from outside it.
const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// One tet's side of a face.
pub(crate) struct FaceSide {
    /// Its nodes in rising order: the same for both sides of a face.
    pub key: [u32; 3],
    pub tet: usize,
    /// Place among the tet's faces: that of the corner opposite.
    pub face: usize,
    /// Its nodes, counter-clockwise seen from outside the tet.
    pub corners: [u32; 3],
}

/// All sides of all faces, those of one face next to each other, in the order of their tets.
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

/// Boundary triangles, shape `[triangles][3]`: the faces of one tet only, in the order of the tets.
/// Counter-clockwise seen from outside if every tet is positively oriented.
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

/// How many pieces tets make that hang together by faces.
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

    #[test]
    fn a_lone_tet_shows_its_four_faces_outward() {
        // Seen along -x, -y, -z and from (1, 1, 1) on the corner of the unit cube.
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
