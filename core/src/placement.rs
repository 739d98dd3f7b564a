//! Placement of a patch under the device: the site is at the device's centre, and the probe's axis
//! points along the device's z.
//!
//! Patches are packed in the frame of their organ. Poses of the device are transformed into that
//! frame, and forces back out of it.
//!
//! * in: a pose, or the output of a tick
//! * out: the same in the other frame
//! * cost: nine multiplications per vector
//! * failures: none

use nalgebra::Vector3;

use crate::stages::output::Output;
use crate::stages::probe::ProbePose;

/// The device's centre and axes in the patch's frame.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    site_m: Vector3<f32>,
    x: Vector3<f32>,
    y: Vector3<f32>,
    z: Vector3<f32>,
}

impl Placement {
    /// Places the site [m] at the device's centre, with the outward unit axis of the press along
    /// its z. The two other axes are computed without a square root and without a branch (Duff et
    /// al., Building an orthonormal basis, revisited, 2017, listing 3).
    #[must_use]
    pub fn new(site_m: Vector3<f32>, axis: Vector3<f32>) -> Self {
        let sign = 1.0_f32.copysign(axis.z);
        let a = -1.0 / (sign + axis.z);
        let b = axis.x * axis.y * a;
        Self {
            site_m,
            x: Vector3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x),
            y: Vector3::new(b, sign + axis.y * axis.y * a, -axis.y),
            z: axis,
        }
    }

    /// Transforms a pose from the device's frame into the patch's.
    #[inline(always)]
    #[must_use]
    pub fn pose_to_patch(&self, pose: ProbePose) -> ProbePose {
        ProbePose { tip_m: self.to_patch(pose.tip_m) }
    }

    /// Transforms an output of the patch into the device's frame.
    #[inline(always)]
    #[must_use]
    pub fn output_to_device(&self, output: Output) -> Output {
        Output {
            force_n: self.turn_to_device(output.force_n),
            normal: self.turn_to_device(output.normal),
            point_m: self.to_device(output.point_m),
            ..output
        }
    }

    /// Moves a point from the device's frame into the patch's [m].
    #[inline(always)]
    #[must_use]
    pub fn to_patch(&self, point_m: Vector3<f32>) -> Vector3<f32> {
        self.site_m + self.turn_to_patch(point_m)
    }

    /// Moves a point from the patch's frame into the device's [m].
    #[inline(always)]
    #[must_use]
    pub fn to_device(&self, point_m: Vector3<f32>) -> Vector3<f32> {
        self.turn_to_device(point_m - self.site_m)
    }

    /// Turns a force [N] or a direction from the device's frame into the patch's.
    #[inline(always)]
    #[must_use]
    pub fn turn_to_patch(&self, vector: Vector3<f32>) -> Vector3<f32> {
        self.x * vector.x + self.y * vector.y + self.z * vector.z
    }

    /// Turns a force [N] or a direction from the patch's frame into the device's.
    #[inline(always)]
    #[must_use]
    pub fn turn_to_device(&self, vector: Vector3<f32>) -> Vector3<f32> {
        Vector3::new(self.x.dot(&vector), self.y.dot(&vector), self.z.dot(&vector))
    }
}

#[cfg(test)]
mod tests {
    use super::Placement;
    use nalgebra::Vector3;

    #[test]
    fn a_patch_that_faces_up_at_the_centre_is_not_moved() {
        let placement = Placement::new(Vector3::zeros(), Vector3::z());
        let point = Vector3::new(0.001, -0.002, 0.003);
        assert_eq!(placement.to_patch(point), point);
        assert_eq!(placement.to_device(point), point);
    }

    #[test]
    fn axes_are_orthonormal_and_right_handed_whatever_the_press() {
        for axis in [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.6, 0.0, 0.8], [-0.48, 0.64, -0.6], [0.0, 1.0, 0.0]] {
            let axis = Vector3::<f32>::from(axis);
            let placement = Placement::new(Vector3::zeros(), axis);
            let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|v| placement.to_patch(v));
            assert_eq!(z, axis);
            assert!((x.cross(&y) - z).norm() < 1e-6 && (x.norm() - 1.0).abs() < 1e-6, "{axis:?}");
            let force = Vector3::new(0.3, -0.2, 1.5);
            assert!((placement.turn_to_device(placement.to_patch(force)) - force).norm() < 1e-6, "{axis:?}");
            let moved = Placement::new(Vector3::new(0.1, -0.2, 0.05), axis);
            assert!((moved.to_device(moved.to_patch(force)) - force).norm() < 1e-6, "{axis:?}");
        }
    }
}
