//! Tolerance for single precision: a bound on the rounding error of each node's force, computed
//! from the magnitudes of the summands.
//!
//! `u = 2^-24` is the largest relative error of one operation. Roundings are assumed independent,
//! so n of them amount to `sqrt(n) u` and not `n u` (Higham & Mary 2019, "A new approach to
//! probabilistic rounding error analysis"). The tolerance is [`SIGMAS`] times that. Components are
//! bounded by lengths.

use palpate::{Model, Params, Vector3};

/// Largest relative error of one operation in `f32`.
pub const UNIT: f64 = 1.0 / (1 << 24) as f64;

/// Number of standard deviations that the tolerance allows.
pub const SIGMAS: f64 = 6.0;
/// Number of operations from a coordinate to a spring's force: subtraction, squares and sums, root,
/// division, compensation, product.
const SPRING_OPERATIONS: f64 = 16.0;
/// Number of operations from a coordinate to six times a tet's volume: two products of edges with
/// their sums, and one more with its sum.
const VOLUME_OPERATIONS: f64 = 16.0;
/// Number of roundings from a pressure and two edges to a corner's force. The first corner's force
/// is the sum of the other three.
const CORNER_OPERATIONS: f64 = 12.0;

/// Bound on the rounding error of the internal force at each node, without rim and contact [N].
///
/// For a spring, the two terms of `q = k - k l0/l` cancel, so the error of the force is that of `k`
/// and `k l0/l` times `l`. For a tet, the volume ratio has the error of a product of three edges,
/// divided by the rest volume; multiplied by the slope of the pressure and by the area of a face,
/// this is the error of the force.
pub fn of_forces_n(model: &Model, params: &Params, x: &[Vector3<f64>]) -> Vec<f64> {
    let mut count = vec![0.0; x.len()];
    let mut sizes = vec![0.0; x.len()]; // term sizes, for the rounding of additions
    let mut squares = vec![0.0; x.len()]; // squares of the terms' own errors
    for s in model.springs {
        let (i, j) = (usize::from(s.i), usize::from(s.j));
        let d = x[j] - x[i];
        let (pulled, rest) = (f64::from(s.k) * d.norm(), f64::from(s.k_rest));
        let stiffer = 1.0 + f64::from(params.compensation);
        for n in [i, j] {
            count[n] += 1.0;
            sizes[n] += (pulled - rest).abs() * stiffer;
            squares[n] += SPRING_OPERATIONS * (UNIT * (pulled + rest) * stiffer).powi(2);
        }
    }
    let shapes: Vec<TetSize> = model.tets.iter().map(|t| TetSize::of(t.node.map(|n| x[usize::from(n)]))).collect();
    let mut star = vec![Star::default(); x.len()];
    for (t, shape) in model.tets.iter().zip(&shapes) {
        for n in t.node.map(usize::from) {
            star[n].six_volume += shape.six_volume;
            star[n].cubes += shape.edge_m.powi(3);
            star[n].tets += 1.0;
        }
    }
    let nodal: Vec<Pressure> = model.nodes.iter().zip(&star).map(|(n, s)| s.pressure(n)).collect();
    for (t, shape) in model.tets.iter().zip(&shapes) {
        let reciprocal = f64::from(t.six_volume_reciprocal);
        let j = shape.six_volume * reciprocal;
        let j_error = VOLUME_OPERATIONS.sqrt() * UNIT * shape.edge_m.powi(3) * reciprocal;
        let mut p = t.node.iter().fold(Pressure::default(), |sum, &n| sum.plus(nodal[usize::from(n)]));
        let bulk = f64::from(t.bulk);
        p = p.plus(Pressure { size: bulk * (j - 1.0).abs(), square: (bulk * j_error).powi(2) });
        if j < 0.4 {
            let barrier = f64::from(t.barrier);
            p = p.plus(Pressure { size: barrier * (1.0 - j / 0.4), square: (barrier / 0.4 * j_error).powi(2) });
        }
        let area_m2 = 3.0 * shape.edge_m.powi(2);
        for n in t.node.map(usize::from) {
            count[n] += 1.0;
            sizes[n] += area_m2 * p.size;
            squares[n] += area_m2.powi(2) * (p.square + CORNER_OPERATIONS * (UNIT * p.size).powi(2));
        }
    }
    let e = f64::from(params.youngs_modulus_pa);
    (0..x.len()).map(|n| SIGMAS * e * (squares[n] + count[n] * (UNIT * sizes[n]).powi(2)).sqrt()).collect()
}

struct TetSize {
    six_volume: f64,
    /// Longest edge [m].
    edge_m: f64,
}

impl TetSize {
    fn of([a, b, c, d]: [Vector3<f64>; 4]) -> Self {
        let edges = [b - a, c - a, d - a, c - b, d - b, d - c];
        Self { six_volume: edges[0].cross(&edges[1]).dot(&edges[2]), edge_m: edges.iter().map(|e| e.norm()).fold(0.0, f64::max) }
    }
}

#[derive(Clone, Copy, Default)]
struct Star {
    six_volume: f64,
    cubes: f64,
    tets: f64,
}

impl Star {
    fn pressure(&self, node: &palpate::NodeRest) -> Pressure {
        let reciprocal = f64::from(node.six_volume_reciprocal);
        let ratio = self.six_volume * reciprocal;
        let j = ratio.max(0.8);
        let j_error = (VOLUME_OPERATIONS + self.tets).sqrt() * UNIT * self.cubes * reciprocal;
        let stiffness = f64::from(node.pressure);
        // derivative of (J - 1) / (J (J + 1)); the difference rounds at the magnitude of J and 1
        let slope = (1.0 + 2.0 * j - j * j).abs() / (j * j * (j + 1.0) * (j + 1.0));
        let size = (j - 1.0).abs() / (j * (j + 1.0)) + slope * (j - ratio);
        Pressure { size: stiffness * size, square: (stiffness * slope * j_error).powi(2) }
    }
}

#[derive(Clone, Copy, Default)]
struct Pressure {
    size: f64,
    /// Square of the pressure's error.
    square: f64,
}

impl Pressure {
    fn plus(self, other: Self) -> Self {
        Self { size: self.size + other.size, square: self.square + other.square }
    }
}

/// Magnitude of a sum of vectors whose roundings are independent.
pub fn together(bounds: impl IntoIterator<Item = f64>) -> f64 {
    bounds.into_iter().map(|b| b * b).sum::<f64>().sqrt()
}
