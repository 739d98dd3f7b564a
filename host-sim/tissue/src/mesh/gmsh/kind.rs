//! Gmsh element type codes, the same in every format.

/// Kind of element, as far as it matters here.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Tet,
    HigherOrderTet,
    Other(&'static str),
}

/// Kind of element with this type code.
pub(super) fn kind(code: u64) -> Kind {
    match code {
        4 => Kind::Tet,
        11 | 29..=33 | 71..=75 | 79..=83 | 137 => Kind::HigherOrderTet,
        1 | 8 | 26..=28 => Kind::Other("line"),
        2 | 9 | 20..=25 => Kind::Other("triangle"),
        3 | 10 | 16 => Kind::Other("quad"),
        5 | 12 | 17 => Kind::Other("hexahedron"),
        6 | 13 | 18 => Kind::Other("prism"),
        7 | 14 | 19 => Kind::Other("pyramid"),
        15 => Kind::Other("point"),
        _ => Kind::Other("other"),
    }
}

/// Number of nodes of an element that is not a tet, so that a binary file can be read past it;
/// `None` for rare kinds.
pub(super) fn nodes_of(code: u64) -> Option<u64> {
    Some(match code {
        15 => 1,
        1 => 2,
        2 | 8 => 3,
        3 | 26 => 4,
        7 | 27 => 5,
        6 | 9 | 28 => 6,
        5 | 16 => 8,
        10 | 20 => 9,
        21 => 10,
        22 => 12,
        19 => 13,
        14 => 14,
        18 | 23 | 24 => 15,
        13 => 18,
        17 => 20,
        12 => 27,
        _ => return None,
    })
}
