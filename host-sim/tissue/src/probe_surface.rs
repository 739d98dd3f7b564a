//! The probe's surface in double precision: penetration of a point, and the corresponding tissue
//! surface.

mod ellipsoid;

use nalgebra::{Matrix3, Vector3};
use palpate::stages::force::foundation::FLAT_EDGE;
use palpate::{Probe, ProbeShape};

pub use ellipsoid::ellipsoid;

use crate::scene::level;

/// Penetration of a point [m], the outward direction along which it decreases (1), and its second
/// derivative [1/m].
pub type Inside = (f64, Vector3<f64>, Matrix3<f64>);

/// Position of the surface at a point of the mesh [m]: inside the probe the foundation is
/// compressed, and its outer face lies on the probe.
#[must_use]
pub fn outer_face_m(probe: &Probe, tip_m: Vector3<f64>, point_m: Vector3<f64>) -> Vector3<f64> {
    inside(probe, point_m - tip_m).map_or(point_m, |(pen, out, _)| point_m + out * pen)
}

/// Penetration of a point at `at`, relative to the tip [m]; `None` outside the probe.
#[must_use]
pub fn inside(probe: &Probe, at: Vector3<f64>) -> Option<Inside> {
    let (axis, r): (Vector3<f64>, f64) = (probe.axis.cast(), f64::from(probe.radius_m));
    let above_tip = at.dot(&axis);
    let across = Matrix3::identity() - axis * axis.transpose();
    if probe.shape == ProbeShape::Flat {
        let edge = r * f64::from(FLAT_EDGE);
        let off_axis = at - axis * above_tip;
        let off = off_axis.norm();
        if above_tip <= 0.0 || off >= r {
            return None;
        }
        if off <= r - edge {
            return Some((above_tip, -axis, Matrix3::zeros()));
        }
        let arm = off_axis * ((off - (r - edge)) / off) - axis * (edge - above_tip).max(0.0);
        let length = arm.norm();
        // the curvature along the ring is small compared with that across it and is neglected
        return (length < edge).then(|| (edge - length, arm / length, Matrix3::zeros()));
    }
    let (mut d, mut around) = (at - axis * r, Matrix3::identity());
    match probe.shape {
        ProbeShape::Hemisphere if above_tip > r => {
            d = at - axis * above_tip;
            around = across;
        }
        ProbeShape::Capsule { length_m, along } => {
            let (along, half_m) = (level(along.cast().into(), axis), 0.5 * f64::from(length_m));
            let place = d.dot(&along);
            d -= along * place.clamp(-half_m, half_m);
            if place.abs() < half_m {
                around -= along * along.transpose();
            }
        }
        ProbeShape::Ellipsoid { semi_axes_m: [a, b], along } => {
            let along = level(along.cast().into(), axis);
            let frame = Matrix3::from_columns(&[along, axis.cross(&along), axis]);
            let (gap_m, out, curvature) = ellipsoid([f64::from(a), f64::from(b), r], frame.transpose() * d);
            return (gap_m < 0.0).then(|| (-gap_m, frame * out, frame * curvature * frame.transpose() * -1.0));
        }
        _ => {}
    }
    let l = d.norm();
    if l >= r || l == 0.0 {
        return None;
    }
    let out = d / l;
    Some((r - l, out, (around - out * out.transpose()) * (-1.0 / l)))
}
