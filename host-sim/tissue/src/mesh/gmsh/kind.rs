//! Gmsh element type codes, the same in every format.

use crate::mesh::element::{Kind, Shape};

/// Kind of element with this type code.
pub(super) fn kind(code: u64) -> Kind {
    let face = |corners, nodes| Kind::Face { corners, nodes };
    match code {
        4 => Kind::solid(Shape::Tet, 4),
        11 => Kind::solid(Shape::Tet, 10),
        5 => Kind::solid(Shape::Hexahedron, 8),
        12 => Kind::solid(Shape::Hexahedron, 27),
        17 => Kind::solid(Shape::Hexahedron, 20),
        6 => Kind::solid(Shape::Prism, 6),
        13 => Kind::solid(Shape::Prism, 18),
        18 => Kind::solid(Shape::Prism, 15),
        7 => Kind::solid(Shape::Pyramid, 5),
        14 => Kind::solid(Shape::Pyramid, 14),
        19 => Kind::solid(Shape::Pyramid, 13),
        29..=33 | 71..=75 | 79..=83 | 137 => Kind::Unread("tet of higher order"),
        92..=105 => Kind::Unread("hexahedron of higher order"),
        90 | 91 | 106..=117 => Kind::Unread("prism of higher order"),
        118..=132 => Kind::Unread("pyramid of higher order"),
        35 => Kind::Unread("polyhedron"),
        2 => face(3, 3),
        9 => face(3, 6),
        3 => face(4, 4),
        10 => face(4, 9),
        16 => face(4, 8),
        1 | 8 | 26..=28 => Kind::Other("line"),
        20..=25 => Kind::Other("triangle"),
        15 => Kind::Other("point"),
        _ => Kind::Other("other"),
    }
}

/// Nodes of an element in the order of VTK: Gmsh exchanges the last two edges of a tet.
pub(super) fn in_order(nodes: &mut [u64]) {
    if nodes.len() == 10 {
        nodes.swap(8, 9);
    }
}

/// Number of nodes of an element, so that a binary file can be read past it; `None` for rare kinds.
pub(super) fn nodes_of(code: u64) -> Option<usize> {
    match kind(code) {
        Kind::Solid { nodes, .. } | Kind::Face { nodes, .. } => return Some(nodes),
        Kind::Unread(_) | Kind::Other(_) => {}
    }
    Some(match code {
        15 => 1,
        1 => 2,
        8 => 3,
        26 => 4,
        27 => 5,
        28 => 6,
        20 => 9,
        21 => 10,
        22 => 12,
        23 | 24 => 15,
        25 => 21,
        29 => 20,
        30 => 35,
        31 => 56,
        90 => 40,
        91 => 75,
        92 => 64,
        93 => 125,
        118 => 30,
        119 => 55,
        _ => return None,
    })
}
