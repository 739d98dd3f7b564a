//! Describes the rigid probe by a signed distance.

use nalgebra::{Matrix3, Vector3};
use palpate::stages::force::foundation::FLAT_EDGE;

use palpate_tissue::probe_surface::ellipsoid;
use palpate_tissue::scene::{Shape, level};

/// A rigid, frictionless probe.
#[derive(Clone, Copy, Debug)]
pub struct RigidProbe {
    /// Shape of the probe. A hemisphere and a disc continue as a cylinder of their radius; the
    /// others have no handle.
    pub shape: Shape,
    /// Radius [m].
    pub radius_m: f64,
    /// Radius of the rounded edge of a disc [m]; other shapes have no edge.
    pub edge_m: f64,
    /// Position of the tip, the foremost point [m].
    pub tip_m: Vector3<f64>,
    /// Unit vector from the tip to the handle.
    pub axis: Vector3<f64>,
}

/// Distance of a point from the probe's surface, with its first two derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Gap {
    /// Distance [m], negative inside the probe.
    pub gap_m: f64,
    /// Gradient of the distance: the unit normal out of the probe.
    pub normal: Vector3<f64>,
    /// Second derivative of the distance [1/m].
    pub curvature_per_m: Matrix3<f64>,
}

impl RigidProbe {
    /// A probe whose tip is at `tip_m`. The edge of a disc is rounded as in the simulation, by a
    /// sixteenth of its radius.
    #[must_use]
    pub fn new(shape: Shape, radius_m: f64, tip_m: Vector3<f64>, axis: Vector3<f64>) -> Self {
        Self { shape, radius_m, edge_m: f64::from(FLAT_EDGE) * radius_m, tip_m, axis }
    }

    /// Signed distance of the point `at_m` from the probe's surface [m], with its derivatives.
    #[must_use]
    pub fn gap(&self, at_m: &Vector3<f64>) -> Gap {
        let arm = at_m - self.tip_m;
        let height = arm.dot(&self.axis);
        let across = arm - self.axis * height;
        let r = across.norm();
        match self.shape {
            Shape::Sphere => self.ball(&arm),
            Shape::Hemisphere if height <= self.radius_m => self.ball(&arm),
            Shape::Hemisphere => self.side(&across, r),
            Shape::Capsule { length_m, along } => self.capsule(&arm, 0.5 * length_m, &level(along, self.axis)),
            Shape::Ellipsoid { semi_axes_m: [a, b], along } => {
                let along = level(along, self.axis);
                let frame = Matrix3::from_columns(&[along, self.axis.cross(&along), self.axis]);
                let at = frame.transpose() * (arm - self.axis * self.radius_m);
                let (gap_m, normal, curvature) = ellipsoid([a, b, self.radius_m], at);
                Gap { gap_m, normal: frame * normal, curvature_per_m: frame * curvature * frame.transpose() }
            }
            Shape::Flat => {
                let inner = self.radius_m - self.edge_m;
                let (out, below) = (r - inner, self.edge_m - height);
                match (out > 0.0, below > 0.0) {
                    (true, true) => self.rim(&across, r, out, below),
                    _ if out > below => self.side(&across, r),
                    _ => Gap { gap_m: -height, normal: -self.axis, curvature_per_m: Matrix3::zeros() },
                }
            }
        }
    }

    fn ball(&self, arm: &Vector3<f64>) -> Gap {
        let arm = arm - self.axis * self.radius_m;
        let length = arm.norm().max(f64::MIN_POSITIVE);
        let normal = arm / length;
        let curvature_per_m = (Matrix3::identity() - normal * normal.transpose()) / length;
        Gap { gap_m: length - self.radius_m, normal, curvature_per_m }
    }

    /// Distance from a ball around the nearest point of the segment. Beside the straight part the
    /// curvature along the segment is zero.
    fn capsule(&self, arm: &Vector3<f64>, half_m: f64, along: &Vector3<f64>) -> Gap {
        let place = arm.dot(along);
        let ball = self.ball(&(arm - along * place.clamp(-half_m, half_m)));
        if place.abs() >= half_m {
            return ball;
        }
        let around = self.radius_m + ball.gap_m;
        let curvature_per_m = ball.curvature_per_m - along * along.transpose() / around.max(f64::MIN_POSITIVE);
        Gap { curvature_per_m, ..ball }
    }

    fn side(&self, across: &Vector3<f64>, r: f64) -> Gap {
        let normal = across / r.max(f64::MIN_POSITIVE);
        let around = self.axis.cross(&normal);
        Gap { gap_m: r - self.radius_m, normal, curvature_per_m: around * around.transpose() / r }
    }

    /// Distance from the rounded edge, which is part of a torus.
    fn rim(&self, across: &Vector3<f64>, r: f64, out: f64, below: f64) -> Gap {
        let length = out.hypot(below);
        let radial = across / r;
        let normal = (radial * out - self.axis * below) / length;
        let (along, around) = ((radial * below + self.axis * out) / length, self.axis.cross(&radial));
        let curvature_per_m = along * along.transpose() / length + around * around.transpose() * (out / (length * r));
        Gap { gap_m: length - self.edge_m, normal, curvature_per_m }
    }
}
