//! Closed surfaces in every file format that is read: a ball and a box.

use std::fmt::Write;

/// A surface: corners in millimetres, and triangles whose corners run counter-clockwise seen from
/// outside.
#[derive(Clone, Debug)]
pub struct Triangles {
    /// Corner positions \[mm\].
    pub corners_mm: Vec<[f64; 3]>,
    /// Corner indices of each triangle.
    pub triangles: Vec<[usize; 3]>,
}

/// An octahedron whose triangles are split into four, which is repeated `times` times, with all
/// corners on the sphere.
pub fn ball(radius_mm: f64, times: u32) -> Triangles {
    let mut corners: Vec<[f64; 3]> =
        vec![[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let mut triangles = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..times {
        let mut halves = std::collections::BTreeMap::new();
        let mut middle = |i: usize, j: usize, corners: &mut Vec<[f64; 3]>| {
            *halves.entry([i.min(j), i.max(j)]).or_insert_with(|| {
                let sum = [0, 1, 2].map(|k| corners[i][k] + corners[j][k]);
                let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
                corners.push(sum.map(|x| x / length));
                corners.len() - 1
            })
        };
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let [x, y, z] = [(a, b), (b, c), (c, a)].map(|(i, j)| middle(i, j, &mut corners));
            finer.extend([[a, x, z], [b, y, x], [c, z, y], [x, y, z]]);
        }
        triangles = finer;
    }
    for x in corners.iter_mut().flatten() {
        *x *= radius_mm;
    }
    Triangles { corners_mm: corners, triangles }
}

/// A box with one corner at the origin.
pub fn cuboid(sides_mm: [f64; 3]) -> Triangles {
    let corners_mm = (0..8).map(|n| [0, 1, 2].map(|k| if n >> k & 1 == 1 { sides_mm[k] } else { 0.0 })).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Triangles { corners_mm, triangles }
}

impl Triangles {
    /// The surface, translated by `by_mm`.
    pub fn moved(mut self, by_mm: [f64; 3]) -> Self {
        for corner in &mut self.corners_mm {
            *corner = [0, 1, 2].map(|k| corner[k] + by_mm[k]);
        }
        self
    }

    /// The surface as PLY, as text.
    pub fn ply(&self) -> String {
        let mut text = format!(
            "ply\nformat ascii 1.0\ncomment a ball\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
            self.corners_mm.len(),
            self.triangles.len()
        );
        for [x, y, z] in &self.corners_mm {
            let _ = writeln!(text, "{x} {y} {z}");
        }
        for [a, b, c] in &self.triangles {
            let _ = writeln!(text, "3 {a} {b} {c}");
        }
        text
    }

    /// Joins two surfaces into one.
    pub fn and(mut self, other: &Self) -> Self {
        let first = self.corners_mm.len();
        self.corners_mm.extend(&other.corners_mm);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|n| n + first)));
        self
    }

    /// Enclosed volume by the divergence theorem \[mm^3\].
    pub fn volume_mm3(&self) -> f64 {
        let of = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|n| self.corners_mm[n]);
            let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            (cross[0] * c[0] + cross[1] * c[1] + cross[2] * c[2]) / 6.0
        };
        self.triangles.iter().map(of).sum()
    }

    /// The surface as OBJ text, in millimetres.
    ///
    /// # Panics
    /// Never panics: writing to a string does not fail.
    pub fn obj(&self) -> String {
        let mut text = String::from("# made by hand\no organ\n");
        for [x, y, z] in &self.corners_mm {
            writeln!(text, "v {x} {y} {z}").unwrap();
        }
        text.push_str("vn 0 0 1\n");
        for t in &self.triangles {
            let [a, b, c] = t.map(|n| n + 1);
            writeln!(text, "f {a}//1 {b}//1 {c}//1").unwrap();
        }
        text
    }

    /// The surface as STL text, in millimetres with seven digits.
    ///
    /// # Panics
    /// Never panics: writing to a string does not fail.
    pub fn stl(&self) -> String {
        let mut text = String::from("solid organ\n");
        for t in &self.triangles {
            text.push_str("  facet normal 0 0 0\n    outer loop\n");
            for [x, y, z] in t.map(|n| self.corners_mm[n]) {
                writeln!(text, "      vertex {x:.6e} {y:.6e} {z:.6e}").unwrap();
            }
            text.push_str("    endloop\n  endfacet\n");
        }
        text + "endsolid organ\n"
    }

    /// The surface as binary STL in millimetres, with a header that begins like that of a text
    /// file.
    pub fn binary_stl(&self) -> Vec<u8> {
        let mut bytes = b"solid organ of a program that writes binary all the same".to_vec();
        bytes.resize(80, b' ');
        bytes.extend((self.triangles.len() as u32).to_le_bytes());
        for t in &self.triangles {
            bytes.extend([0; 12]);
            for x in t.iter().flat_map(|n| self.corners_mm[*n]) {
                bytes.extend((x as f32).to_le_bytes());
            }
            bytes.extend([0; 2]);
        }
        bytes
    }
}

/// The projective plane on six corners: a closed surface of one side.
pub fn projective_plane() -> Triangles {
    Triangles {
        corners_mm: (0..6).map(|n| [f64::from(n), f64::from(n * n), f64::from(n * n * n)]).collect(),
        triangles: vec![
            [0, 1, 2],
            [0, 2, 3],
            [0, 3, 4],
            [0, 4, 5],
            [0, 5, 1],
            [1, 2, 4],
            [2, 3, 5],
            [3, 4, 1],
            [4, 5, 2],
            [5, 1, 3],
        ],
    }
}
