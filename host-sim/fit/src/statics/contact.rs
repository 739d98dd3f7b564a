//! The foundation under the probe: force of each point over E, its derivative, and the curvature of
//! the probe.

use nalgebra::Matrix3;
use palpate::stages::force::foundation::point_weights;
use palpate_tissue::probe_surface::{Inside, inside};

use super::{StaticTriangle, Statics, Vector};

/// A foundation point inside the probe, with its force.
pub(super) struct Push {
    pub triangle: usize,
    pub point: usize,
    pub weights: [f64; 3],
    /// Unit vector out of the probe.
    pub out: Vector,
    /// Force along `out` over E [m^2].
    pub force: f64,
    /// Energy of the point over E [m^3].
    pub energy: f64,
    /// Derivative of the force with respect to the logarithm of the stiffening coefficient, `d f /
    /// d ln s` [m^2].
    pub by_stiffening: f64,
    /// Second derivative of the energy with respect to the point's position [m].
    pub curvature: Matrix3<f64>,
}

impl Statics {
    pub(super) fn pushes(&self, x: &[Vector], tip_m: Vector) -> Vec<Push> {
        let r = f64::from(self.probe.radius_m);
        let mut pushes = Vec::new();
        for (triangle, t) in self.triangles.iter().enumerate() {
            let corners = t.node.map(|n| x[n] - tip_m);
            // the tip is the probe's lowest point along its axis, so a triangle completely below it
            // cannot be inside
            if corners.iter().all(|c| c.dot(&self.axis()) < 0.0) || corners.iter().all(|c| c.norm_squared() > 36.0 * r * r) {
                continue;
            }
            for (point, weights) in point_weights(t.k.len()).iter().enumerate() {
                let weights = weights.map(f64::from);
                let at = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
                if let Some(inside) = self.inside(at) {
                    pushes.push(self.push(triangle, t, point, weights, inside));
                }
            }
        }
        pushes
    }

    fn push(&self, triangle: usize, t: &StaticTriangle, point: usize, weights: [f64; 3], (pen, out, bend): Inside) -> Push {
        let (k, s) = (t.k[point], self.stiffening_per_m);
        let force = k * pen * (1.0 + s * pen);
        let slope = k * (1.0 + 2.0 * s * pen);
        // for the energy phi(pen): gradient = -f out, curvature = slope out out^T + f bend
        let curvature = out * out.transpose() * slope + bend * force;
        Push {
            triangle,
            point,
            weights,
            out,
            force,
            energy: k * pen * pen * (0.5 + s * pen / 3.0),
            by_stiffening: k * s * pen * pen,
            curvature,
        }
    }
}

impl Statics {
    /// Penetration, normal and curvature if `at` is inside the probe; `at` is relative to the tip
    /// [m].
    pub(super) fn inside(&self, at: Vector) -> Option<Inside> {
        inside(&self.probe, at)
    }
}
