//! Springs and volume: first and second derivatives of their energies over E.

use nalgebra::Matrix3;

use super::{StaticSpring, StaticTet, Statics, Vector};

/// Volume ratio of a node below which its pressure continues along the tangent, as in the tick (1).
const STRAIGHT_BELOW: f64 = 0.8;
/// Volume ratio of a tet below which its barrier acts, as in the tick (1).
const BARRIER_BELOW: f64 = 0.4;

/// State of a spring: unit vector from i to j, length [m], tension over E [m^2], and derivative of
/// the tension with respect to the length over E [m].
pub(super) struct Pull {
    pub along: Vector,
    pub length_m: f64,
    pub tension: f64,
    pub slope: f64,
    /// Stiffness over E [m], and elongation [m].
    pub k: f64,
    pub stretch_m: f64,
    /// Compression beyond the threshold of the compensation [m]; zero or negative.
    pub squeeze_m: f64,
}

impl Statics {
    pub(super) fn pull(&self, s: &StaticSpring, x: &[Vector]) -> Pull {
        let d = x[s.node[1]] - x[s.node[0]];
        let length_m = d.norm();
        let onset_m = (1.0 - self.compensation_threshold) * s.rest_m;
        let squeeze_m = if self.compensation_acts { (length_m - onset_m).min(0.0) } else { 0.0 };
        let extra = if squeeze_m < 0.0 { self.compensation * s.k } else { 0.0 };
        Pull {
            along: d / length_m,
            length_m,
            tension: s.k * (length_m - s.rest_m) + extra * squeeze_m,
            slope: s.k + extra,
            k: s.k,
            stretch_m: length_m - s.rest_m,
            squeeze_m,
        }
    }
}

impl Pull {
    /// Energy of the spring over E [m^3].
    pub fn energy(&self) -> f64 {
        0.5 * self.k * self.stretch_m * self.stretch_m + 0.5 * (self.slope - self.k) * self.squeeze_m * self.squeeze_m
    }

    /// Second derivative of the energy over E with respect to the difference of the ends [m].
    pub fn curvature(&self) -> Matrix3<f64> {
        let nn = self.along * self.along.transpose();
        nn * self.slope + (Matrix3::identity() - nn) * (self.tension / self.length_m)
    }
}

/// State of a tet: gradients of six times its volume [m^2], edges [m], and six times its volume
/// [m^3].
pub(super) struct TetGeometry {
    pub gradient: [Vector; 4],
    pub edges: [Vector; 3],
    pub six_volume: f64,
}

pub(super) fn geometry(t: &StaticTet, x: &[Vector]) -> TetGeometry {
    let [a, b, c, d] = t.node.map(|n| x[n]);
    let edges = [b - a, c - a, d - a];
    let [e1, e2, e3] = edges;
    let (g1, g2, g3) = (e2.cross(&e3), e3.cross(&e1), e1.cross(&e2));
    TetGeometry { gradient: [-(g1 + g2 + g3), g1, g2, g3], edges, six_volume: e1.dot(&g1) }
}

impl TetGeometry {
    /// Second derivatives of six times the volume [m]; rows and columns are corners. `between(i,
    /// j)` is the transpose of `between(j, i)`.
    pub fn between(&self) -> [[Matrix3<f64>; 4]; 4] {
        let [e1, e2, e3] = self.edges.map(|e| e.cross_matrix());
        // d g1 = de2 x e3 + e2 x de3, and cyclically
        let inner = [[Matrix3::zeros(), -e3, e2], [e3, Matrix3::zeros(), -e1], [-e2, e1, Matrix3::zeros()]];
        let mut all = [[Matrix3::zeros(); 4]; 4];
        for i in 0..3 {
            for j in 0..3 {
                all[i + 1][j + 1] = inner[i][j];
                all[0][j + 1] -= inner[i][j];
                all[i + 1][0] -= inner[i][j];
                all[0][0] += inner[i][j];
            }
        }
        all
    }
}

/// Pressure over E of a tet's own volume energy and barrier, and its derivative with respect to six
/// times the volume.
pub(super) fn own_pressure(t: &StaticTet, six_volume: f64, barrier: bool) -> (f64, f64) {
    let j = six_volume * t.six_volume_reciprocal;
    let (mut p, mut slope) = (t.bulk * (j - 1.0), t.bulk);
    if barrier && j < BARRIER_BELOW {
        p -= t.barrier * (1.0 - j / BARRIER_BELOW);
        slope += t.barrier / BARRIER_BELOW;
    }
    (p, slope * t.six_volume_reciprocal)
}

impl Statics {
    /// Pressure of each node over E, and its derivative with respect to six times the node's
    /// volume.
    pub(super) fn node_pressures(&self, around: &[f64]) -> Vec<(f64, f64)> {
        let law = |n: usize| {
            let (c, r) = (self.pressure[n], self.six_volume_reciprocal[n]);
            let ratio = around[n] * r;
            let j = ratio.max(STRAIGHT_BELOW);
            let below = j * (j + 1.0);
            let slope = (1.0 + 2.0 * j - j * j) / (below * below);
            (c * ((j - 1.0) / below + slope * (ratio - j)), c * r * slope)
        };
        (0..around.len()).map(law).collect()
    }
}
