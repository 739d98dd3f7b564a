//! Quadratic shape functions and quadrature rules of the 10-node tet and the 6-node triangle
//! (Zienkiewicz and Taylor, *The Finite Element Method*).

use nalgebra::{Matrix3, Vector3};

/// Corner pairs of a tet's edges; node `4 + e` is the middle of edge `e`.
pub const TET_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];
/// Corner pairs of a triangle's sides; node `3 + s` is the middle of side `s`.
pub const TRIANGLE_EDGES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// Quadrature rule of a tet: volume coordinates and share of the volume of each point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TetRule {
    /// Four points, exact to degree 2; used for solutions.
    #[default]
    Four,
    /// Eleven points, exact to degree 4 (Keast 1986), for integrands that need it and to check the
    /// other rule.
    Eleven,
}

impl TetRule {
    /// Points as (volume coordinates, share of the volume); the shares add up to 1.
    #[must_use]
    pub fn points(self) -> Vec<([f64; 4], f64)> {
        match self {
            Self::Four => {
                let root = 5_f64.sqrt();
                let (a, b) = ((5.0 + 3.0 * root) / 20.0, (5.0 - root) / 20.0);
                (0..4).map(|k| (peak(k, a, b), 0.25)).collect()
            }
            Self::Eleven => {
                let mut points = vec![([0.25; 4], -148.0 / 1875.0)];
                points.extend((0..4).map(|k| (peak(k, 11.0 / 14.0, 1.0 / 14.0), 343.0 / 7500.0)));
                let root = (5.0_f64 / 14.0).sqrt();
                let (a, b) = (0.25 * (1.0 + root), 0.25 * (1.0 - root));
                points.extend(TET_EDGES.map(|[i, j]| {
                    let mut at = [b; 4];
                    at[i] = a;
                    at[j] = a;
                    (at, 56.0 / 375.0)
                }));
                points
            }
        }
    }
}

fn peak(k: usize, high: f64, low: f64) -> [f64; 4] {
    let mut at = [low; 4];
    at[k] = high;
    at
}

/// Quadrature rule of a triangle with seven points (area coordinates, share of the area), exact to
/// degree 5 (Radon 1948).
#[must_use]
pub fn triangle_points() -> [([f64; 3], f64); 7] {
    let root = 15_f64.sqrt();
    let (inner, outer) = ((6.0 + root) / 21.0, (6.0 - root) / 21.0);
    let (heavy, light) = ((155.0 + root) / 1200.0, (155.0 - root) / 1200.0);
    let at = |k: usize, low: f64| {
        let mut at = [low; 3];
        at[k] = 1.0 - 2.0 * low;
        at
    };
    let third = 1.0 / 3.0;
    [
        ([third; 3], 0.225),
        (at(0, inner), heavy),
        (at(1, inner), heavy),
        (at(2, inner), heavy),
        (at(0, outer), light),
        (at(1, outer), light),
        (at(2, outer), light),
    ]
}

/// Values of the shape functions of the 6-node triangle at area coordinates.
#[must_use]
pub fn triangle_shape(at: [f64; 3]) -> [f64; 6] {
    let mut values = [0.0; 6];
    for k in 0..3 {
        let [i, j] = TRIANGLE_EDGES[k];
        values[k] = at[k] * (2.0 * at[k] - 1.0);
        values[3 + k] = 4.0 * at[i] * at[j];
    }
    values
}

/// Derivatives of the shape functions of the 6-node triangle with respect to the first two area
/// coordinates; the third decreases accordingly.
#[must_use]
pub fn triangle_slopes(at: [f64; 3]) -> [[f64; 2]; 6] {
    let mut slopes = [[0.0; 3]; 6];
    for k in 0..3 {
        let [i, j] = TRIANGLE_EDGES[k];
        slopes[k][k] = 4.0 * at[k] - 1.0;
        (slopes[3 + k][i], slopes[3 + k][j]) = (4.0 * at[j], 4.0 * at[i]);
    }
    slopes.map(|[a, b, c]| [a - c, b - c])
}

/// Values of the shape functions of the 10-node tet at volume coordinates.
#[must_use]
pub fn tet_shape(at: [f64; 4]) -> [f64; 10] {
    let mut values = [0.0; 10];
    for k in 0..4 {
        values[k] = at[k] * (2.0 * at[k] - 1.0);
    }
    for (e, [i, j]) in TET_EDGES.into_iter().enumerate() {
        values[4 + e] = 4.0 * at[i] * at[j];
    }
    values
}

/// Gradients of the shape functions of the 10-node tet [1/m] at volume coordinates, from the
/// gradients of the volume coordinates [1/m].
#[must_use]
pub fn tet_gradients(at: [f64; 4], slopes: &[Vector3<f64>; 4]) -> [Vector3<f64>; 10] {
    let mut gradients = [Vector3::zeros(); 10];
    for k in 0..4 {
        gradients[k] = slopes[k] * (4.0 * at[k] - 1.0);
    }
    for (e, [i, j]) in TET_EDGES.into_iter().enumerate() {
        gradients[4 + e] = (slopes[j] * at[i] + slopes[i] * at[j]) * 4.0;
    }
    gradients
}

/// Gradients of the shape functions of a 10-node tet [1/m], whose edges may be curved, at volume
/// coordinates, and the volume that the tet would have if it were deformed everywhere as there
/// [m^3].
#[must_use]
pub fn tet_at(at: [f64; 4], nodes_m: &[Vector3<f64>; 10]) -> ([Vector3<f64>; 10], f64) {
    // derivatives with respect to the last three volume coordinates; the first decreases
    // accordingly
    let unit = [Vector3::repeat(-1.0), Vector3::x(), Vector3::y(), Vector3::z()];
    let slopes = tet_gradients(at, &unit);
    let stretch: Matrix3<f64> = nodes_m.iter().zip(&slopes).map(|(x, slope)| x * slope.transpose()).sum();
    let inverse = stretch.try_inverse().unwrap_or_else(Matrix3::zeros).transpose();
    (slopes.map(|slope| inverse * slope), stretch.determinant() / 6.0)
}

/// Gradients of the volume coordinates of a tet [1/m], and its volume [m^3], which is positive if
/// the tet is positively oriented.
#[must_use]
pub fn tet_slopes(corners: [Vector3<f64>; 4]) -> ([Vector3<f64>; 4], f64) {
    let [a, b, c] = [1, 2, 3].map(|k: usize| corners[k] - corners[0]);
    let six = a.cross(&b).dot(&c);
    let (ga, gb, gc) = (b.cross(&c) / six, c.cross(&a) / six, a.cross(&b) / six);
    ([-(ga + gb + gc), ga, gb, gc], six / 6.0)
}
