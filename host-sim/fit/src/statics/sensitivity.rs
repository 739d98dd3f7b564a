//! Derivatives of the force, or of a displacement, with respect to every constant of the patch, by
//! the adjoint of the equilibrium.
//!
//! In equilibrium the gradient of the energy is zero: `g(x, p) = 0`. For an output `y(x, p)` with
//! `b = dy/dx`, the solution of `K l = b` gives `dy/dp = dp y - l . dp g` for any number of
//! constants. For the force on the probe, `l` is also the displacement with which the tissue
//! follows the press, with the opposite sign.

use super::equilibrium::Balance;
use super::{Statics, Vector, elastic};

/// Derivatives of an output with respect to the logarithm of every constant (for `compensation` and
/// `compensation_threshold`, with respect to the value itself).
#[derive(Clone, Debug)]
pub struct Gradient {
    /// Derivatives with respect to the springs' stiffnesses, shape \[springs\].
    pub spring: Vec<f64>,
    /// Derivatives with respect to the nodal volume stiffnesses, shape \[nodes\].
    pub node: Vec<f64>,
    /// Derivatives with respect to the stiffnesses of the foundation points, shape
    /// [triangles][points].
    pub point: Vec<Vec<f64>>,
    /// Derivatives with respect to the volume stiffnesses of the tets themselves, shape \[tets\].
    pub bulk: Vec<f64>,
    /// Derivative with respect to the stiffening of the foundation.
    pub stiffening: f64,
    /// Derivative with respect to chi.
    pub compensation: f64,
    /// Derivative with respect to `tau_c`.
    pub compensation_threshold: f64,
}

impl Balance {
    /// Derivatives of the force on the probe over E [m^2].
    #[must_use]
    pub fn force_gradient(&self, statics: &Statics) -> Gradient {
        let axis = statics.axis();
        let mut by_position = vec![Vector::zeros(); self.x_m.len()];
        for push in statics.pushes(&self.x_m, self.tip_m) {
            let along = push.curvature * axis;
            let node = statics.triangles[push.triangle].node;
            node.iter().zip(push.weights).for_each(|(&n, w)| by_position[n] += along * w);
        }
        let adjoint = self.factor.solve_nodes(statics, &by_position);
        self.gradient(statics, &adjoint, axis)
    }

    /// Derivatives of `along . position of the surface at the node` [m]. A node inside the probe
    /// carries a compressed layer whose outer face is on the probe; there only the displacement
    /// tangential to the probe's surface counts.
    #[must_use]
    pub fn surface_gradient(&self, statics: &Statics, node: usize, along: Vector) -> Gradient {
        let mut by_position = vec![Vector::zeros(); self.x_m.len()];
        by_position[node] = match statics.inside(self.x_m[node] - self.tip_m) {
            Some((pen, out, bend)) => along - out * out.dot(&along) - bend * along * pen,
            None => along,
        };
        let adjoint = self.factor.solve_nodes(statics, &by_position);
        self.gradient(statics, &adjoint, Vector::zeros())
    }

    /// Position of the surface at a node [m]: that of the node, or the nearest point on the probe's
    /// surface if the node is inside.
    #[must_use]
    pub fn surface_m(&self, statics: &Statics, node: usize) -> Vector {
        let x = self.x_m[node];
        statics.inside(x - self.tip_m).map_or(x, |(pen, out, _)| x + out * pen)
    }

    fn gradient(&self, statics: &Statics, adjoint: &[Vector], explicit: Vector) -> Gradient {
        let x = &self.x_m;
        let mut spring = vec![0.0; statics.springs.len()];
        let (mut compensation, mut threshold) = (0.0, 0.0);
        for (s, slope) in statics.springs.iter().zip(&mut spring) {
            let pull = statics.pull(s, x);
            let opens = (adjoint[s.node[1]] - adjoint[s.node[0]]).dot(&pull.along);
            *slope = -opens * pull.tension;
            if pull.squeeze_m < 0.0 {
                compensation -= opens * s.k * pull.squeeze_m;
                threshold -= opens * statics.compensation * s.k * s.rest_m;
            }
        }
        let (mut node, mut bulk) = (vec![0.0; x.len()], vec![0.0; statics.tets.len()]);
        if statics.volume_acts {
            let (mut around, mut swell) = (vec![0.0; x.len()], vec![0.0; x.len()]);
            for (t, bulk) in statics.tets.iter().zip(&mut bulk) {
                let shape = elastic::geometry(t, x);
                let grows: f64 = t.node.iter().zip(&shape.gradient).map(|(&n, g)| adjoint[n].dot(g)).sum();
                for &n in &t.node {
                    around[n] += shape.six_volume;
                    swell[n] += grows;
                }
                *bulk = -t.bulk * (shape.six_volume * t.six_volume_reciprocal - 1.0) * grows;
            }
            for ((slope, (p, _)), swell) in node.iter_mut().zip(statics.node_pressures(&around)).zip(swell) {
                *slope = -p * swell;
            }
        }
        let mut point: Vec<Vec<f64>> = statics.triangles.iter().map(|t| vec![0.0; t.k.len()]).collect();
        let mut stiffening = 0.0;
        for push in statics.pushes(x, self.tip_m) {
            let corners = statics.triangles[push.triangle].node;
            let moved: Vector = corners.iter().zip(push.weights).map(|(&n, w)| adjoint[n] * w).sum();
            let lever = push.out.dot(&(moved - explicit));
            point[push.triangle][push.point] = push.force * lever;
            stiffening += push.by_stiffening * lever;
        }
        Gradient { spring, node, point, bulk, stiffening, compensation, compensation_threshold: threshold }
    }
}
