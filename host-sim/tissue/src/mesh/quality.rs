//! Signed volume and shape of one tet.

use std::f64::consts::SQRT_2;

/// The tet of lowest quality in a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstTet {
    /// Index in `TetMesh::tets`.
    pub index: usize,
    /// Volume over the cube of the longest edge, 1 for the regular tet.
    pub quality: f64,
}

/// Corner positions [m] of a tet, shape `[4][3]`. Its indices must be in range.
pub(super) fn corners(nodes_m: &[[f64; 3]], tet: [u32; 4]) -> [[f64; 3]; 4] {
    tet.map(|node| nodes_m[node as usize])
}

/// Six times the volume [m^3]: `(b-a) x (c-a) . (d-a)`, positive for a positively oriented tet.
pub(super) fn six_volumes([a, b, c, d]: [[f64; 3]; 4]) -> f64 {
    let (u, v, w) = (minus(b, a), minus(c, a), minus(d, a));
    (u[1] * v[2] - u[2] * v[1]) * w[0] + (u[2] * v[0] - u[0] * v[2]) * w[1] + (u[0] * v[1] - u[1] * v[0]) * w[2]
}

/// Six times the volume of a tet of a mesh [m^3].
pub(crate) fn six_volume(mesh: &super::TetMesh, [a, b, c, d]: [u32; 4]) -> f64 {
    // turned about its first corner, which is the rounding of the patch files that ship
    six_volumes(corners(&mesh.nodes_m, [a, c, d, b]))
}

/// Volume over the cube of the longest edge, scaled to 1 for the regular tet; 0 is flat.
/// Not a number if the edges are too short for a cube in `f64`.
pub(super) fn quality(corners: [[f64; 3]; 4]) -> f64 {
    let [a, b, c, d] = corners;
    let edges = [(a, b), (a, c), (a, d), (b, c), (b, d), (c, d)];
    let mut longest_squared = 0.0;
    for (from, to) in edges {
        let [x, y, z] = minus(to, from);
        let squared = x * x + y * y + z * z;
        if squared > longest_squared {
            longest_squared = squared;
        }
    }
    SQRT_2 * six_volumes(corners).abs() / (longest_squared * longest_squared.sqrt())
}

/// Index and quality of the flattest tet; `None` without tets.
#[must_use]
pub fn worst(mesh: &super::TetMesh) -> Option<WorstTet> {
    let each = mesh.tets.iter().map(|tet| quality(corners(&mesh.nodes_m, *tet))).enumerate();
    each.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, quality)| WorstTet { index, quality })
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Side of the equilateral triangle with this area [m].
pub(crate) fn element_size(area_m2: f64) -> f64 {
    (4.0 * area_m2 / 3.0_f64.sqrt()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const REGULAR: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];

    #[test]
    fn the_regular_tet_has_quality_one_at_every_scale() {
        for scale in [1e-30, 1e-6, 1e-3, 1.0, 1e6] {
            let tet = REGULAR.map(|corner| corner.map(|x| scale * x));
            // Tolerance: a dozen rounding errors of 1e-16 each.
            assert!((quality(tet) - 1.0).abs() < 1e-14, "scale {scale}");
        }
    }

    #[test]
    fn the_corner_of_a_cube_has_a_sixth_of_its_volume() {
        let [o, x, y, z] = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]];
        assert_eq!(six_volumes([o, x, y, z]), 8.0);
        assert_eq!(six_volumes([o, x, z, y]), -8.0);
    }

    #[test]
    fn a_tet_in_a_plane_has_quality_zero() {
        let tet = [[0.0; 3], [1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [1.0, 1.0, 1.0]];
        assert_eq!(quality(tet), 0.0);
    }
}
