//! Kinds of elements, and the division of solids into tets.

/// Kind of an element, whatever the format and its code for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// A solid that is read as tets. `nodes` is the number of nodes that the file gives for it,
    /// those at the corners first.
    Solid { shape: Shape, nodes: usize },
    /// A piece of a surface with this number of corners, and of nodes in the file.
    Face { corners: usize, nodes: usize },
    /// A solid of a kind that is not read.
    Unread(&'static str),
    /// A point, a line, or anything else that has no part in a body.
    Other(&'static str),
}

/// Shape of a solid. Corners are numbered as in Gmsh and VTK.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    Tet,
    Pyramid,
    Prism,
    Hexahedron,
}

impl Kind {
    pub const fn solid(shape: Shape, nodes: usize) -> Self {
        Self::Solid { shape, nodes }
    }

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solid { shape, .. } => shape.name(),
            Self::Face { corners: 3, .. } => "triangle",
            Self::Face { .. } => "quad",
            Self::Unread(name) | Self::Other(name) => name,
        }
    }
}

impl Shape {
    pub fn name(self) -> &'static str {
        match self {
            Self::Tet => "tet",
            Self::Pyramid => "pyramid",
            Self::Prism => "prism",
            Self::Hexahedron => "hexahedron",
        }
    }

    pub fn corners(self) -> usize {
        match self {
            Self::Tet => 4,
            Self::Pyramid => 5,
            Self::Prism => 6,
            Self::Hexahedron => 8,
        }
    }

    /// The faces, by their corners in order around each.
    fn faces(self) -> &'static [&'static [usize]] {
        match self {
            Self::Tet => &[&[0, 1, 2], &[0, 1, 3], &[1, 2, 3], &[0, 2, 3]],
            Self::Pyramid => &[&[0, 1, 2, 3], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]],
            Self::Prism => &[&[0, 1, 2], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]],
            Self::Hexahedron => &[&[0, 1, 2, 3], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]],
        }
    }

    /// Divides a solid into tets that fit those of its neighbours: a quad is always divided by the
    /// diagonal through its node of lowest number, which the neighbour chooses too. All tets share
    /// the node of lowest number; the faces that do not have it are their other faces. A solid
    /// with coinciding corners gives fewer tets. The orientation of the tets is arbitrary.
    pub fn tets(self, nodes: &[u64]) -> Vec<[u64; 4]> {
        let Some(top) = nodes.iter().take(self.corners()).copied().min() else { return Vec::new() };
        let mut tets = Vec::new();
        for face in self.faces() {
            let around: Vec<u64> = face.iter().map(|corner| nodes[*corner]).collect();
            if around.contains(&top) {
                continue;
            }
            let lowest = (0..around.len()).min_by_key(|k| around[*k]).unwrap_or(0);
            let at = |step: usize| around[(lowest + step) % around.len()];
            for step in 1..around.len() - 1 {
                let [a, b, c] = [at(0), at(step), at(step + 1)];
                if a != b && b != c && c != a {
                    tets.push([top, a, b, c]);
                }
            }
        }
        tets
    }
}

/// Divides a tet with nodes on its edges into eight. The nodes are the corners, then the middles of
/// the edges 01, 12, 20, 03, 13, 23 (the order of VTK).
pub(super) fn eight_tets(n: &[u64; 10]) -> [[u64; 4]; 8] {
    let [a, b, c, d, ab, bc, ca, ad, bd, cd] = *n;
    [
        [a, ab, ca, ad],
        [b, bc, ab, bd],
        [c, ca, bc, cd],
        [d, ad, cd, bd],
        // the octahedron between them, around the line from the middle of ab to that of cd
        [ab, cd, bc, ca],
        [ab, cd, ca, ad],
        [ab, cd, ad, bd],
        [ab, cd, bd, bc],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners of each shape in a unit cube.
    fn places(shape: Shape) -> Vec<[f64; 3]> {
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let raised = |at: &[f64; 3]| [at[0], at[1], 1.0];
        match shape {
            Shape::Tet => vec![square[0], square[1], square[3], [0.0, 0.0, 1.0]],
            Shape::Pyramid => square.into_iter().chain([[0.5, 0.5, 1.0]]).collect(),
            Shape::Prism => {
                let base = [square[0], square[1], square[3]];
                base.iter().copied().chain(base.iter().map(raised)).collect()
            }
            Shape::Hexahedron => square.iter().copied().chain(square.iter().map(raised)).collect(),
        }
    }

    #[test]
    fn every_numbering_of_a_solid_divides_it_into_tets_of_its_volume() {
        for (shape, volume) in
            [(Shape::Tet, 1.0 / 6.0), (Shape::Pyramid, 1.0 / 3.0), (Shape::Prism, 0.5), (Shape::Hexahedron, 1.0)]
        {
            let places = places(shape);
            for turn in 0..200_u64 {
                // a permutation: the keys are distinct
                let mut order: Vec<usize> = (0..places.len()).collect();
                order.sort_by_key(|k| (*k as u64 + 1) * 7919 * (turn + 3) % 1009);
                let mut nodes = vec![0; places.len()];
                order.iter().enumerate().for_each(|(number, corner)| nodes[*corner] = number as u64);
                let six: f64 = shape
                    .tets(&nodes)
                    .iter()
                    .map(|tet| {
                        let corners = tet.map(|number| places[order[number as usize]]);
                        super::super::quality::six_volumes(corners).abs()
                    })
                    .sum();
                assert!((six / 6.0 - volume).abs() < 1e-12, "{shape:?} {nodes:?}: {six}");
            }
        }
    }

    #[test]
    fn a_tet_of_second_order_is_divided_without_rest() {
        let c = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let middle = |i: usize, j: usize| [0, 1, 2].map(|k| 0.5 * (c[i][k] + c[j][k]));
        let places: Vec<[f64; 3]> =
            c.into_iter().chain([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)].map(|(i, j)| middle(i, j))).collect();
        let numbers = std::array::from_fn(|n| n as u64);
        for tet in eight_tets(&numbers) {
            let six = super::super::quality::six_volumes(tet.map(|n| places[n as usize])).abs();
            assert!((six - 0.125).abs() < 1e-12, "{tet:?}: {six}");
        }
    }
}
