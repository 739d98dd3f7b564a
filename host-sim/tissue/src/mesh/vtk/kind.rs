//! VTK cell type codes, the same in every format.

use crate::mesh::element::{Kind, Shape};

/// Kind of a cell with this type code and number of nodes. A Lagrange or Bezier cell has as many
/// nodes as its order needs.
pub(super) fn kind(code: u64, nodes: usize) -> Kind {
    let face = |corners, nodes| Kind::Face { corners, nodes };
    match (code, nodes) {
        (10, _) | (71 | 78, 4) => Kind::solid(Shape::Tet, 4),
        (24, _) | (71, 10) => Kind::solid(Shape::Tet, 10),
        (11 | 12, _) | (72 | 79, 8) => Kind::solid(Shape::Hexahedron, 8),
        (25, _) | (72, 20) => Kind::solid(Shape::Hexahedron, 20),
        (33, _) => Kind::solid(Shape::Hexahedron, 24),
        (29, _) | (72, 27) => Kind::solid(Shape::Hexahedron, 27),
        (13, _) | (73 | 80, 6) => Kind::solid(Shape::Prism, 6),
        (31, _) => Kind::solid(Shape::Prism, 12),
        (26, _) | (73, 15) => Kind::solid(Shape::Prism, 15),
        (32, _) | (73, 18) => Kind::solid(Shape::Prism, 18),
        (14, _) | (74 | 81, 5) => Kind::solid(Shape::Pyramid, 5),
        (27, _) | (74, 13) => Kind::solid(Shape::Pyramid, 13),
        (74, 14) => Kind::solid(Shape::Pyramid, 14),
        (37, _) => Kind::solid(Shape::Pyramid, 19),
        (71 | 78, _) => Kind::Unread("tet of higher order"),
        (72 | 79, _) => Kind::Unread("hexahedron of higher order"),
        (73 | 80, _) => Kind::Unread("prism of higher order"),
        (74 | 81, _) => Kind::Unread("pyramid of higher order"),
        (15, _) => Kind::Unread("pentagonal prism"),
        (16, _) => Kind::Unread("hexagonal prism"),
        (41 | 42, _) => Kind::Unread("polyhedron"),
        (5, _) => face(3, 3),
        (22, _) | (69, 6) => face(3, 6),
        (34, _) => face(3, 7),
        (69 | 76, 3) => face(3, 3),
        (8 | 9, _) | (70 | 77, 4) => face(4, 4),
        (23, _) => face(4, 8),
        (30, _) => face(4, 6),
        (28, _) | (70, 9) => face(4, 9),
        (7, 3..) => face(nodes, nodes),
        (1 | 2, _) => Kind::Other("point"),
        (3 | 4 | 21 | 35 | 68 | 75, _) => Kind::Other("line"),
        (69 | 76, _) => Kind::Other("triangle"),
        (70 | 77, _) => Kind::Other("quad"),
        _ => Kind::Other("other"),
    }
}

/// Type codes whose corners are numbered by rows, not around each face: pixel and voxel.
const BY_ROWS: [u64; 2] = [8, 11];

/// Puts the nodes of a cell in the order of the other cells of its kind.
pub(super) fn in_order(code: u64, nodes: &mut [u64]) {
    if BY_ROWS.contains(&code) {
        for square in nodes.chunks_exact_mut(4) {
            square.swap(2, 3);
        }
    }
}

/// Type code of a strip of triangles, each of which has the last two nodes of the one before.
pub(super) const STRIP: u64 = 6;
