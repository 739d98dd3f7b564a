//! Two joints: the five-bar pantograph, as in a Haply or a Pantograph Mk II (Campion, Wang and
//! Hayward, The Pantograph Mk-II: a haptic instrument, IROS 2005, whose forward kinematics are used
//! here).
//!
//! The motors are at x = 0 and x = -base on the device's x axis and drive the proximal arms
//! `near_m`; the distal arms `far_m` meet at the tip. The tip moves in the x-z plane: z is up, out
//! of the tissue.

use palpate::{Vector3, square_root};

use super::{DIMENSIONS, Mechanism, MechanismError, sin_cos};

/// A symmetric five-bar linkage; joint angles are measured from x.
#[derive(Clone, Copy, Debug)]
pub struct Pantograph {
    /// Distance from motor to elbow [m].
    pub near_m: f32,
    /// Distance from elbow to tip [m].
    pub far_m: f32,
    /// Distance between the motors [m].
    pub base_m: f32,
    /// Position of the device's centre in the frame of the first motor, x and z [m].
    pub centre_m: [f32; 2],
    /// Jacobian of the tip position: `[[dx/dq1, dx/dq2], [dz/dq1, dz/dq2]]` [m].
    jacobian_m: [[f32; 2]; 2],
}

/// Least squared ratio of elbow distance to distal-arm length (1): below it the distal arms nearly
/// coincide, and a sideways force takes ten times the torque per newton.
const FOLDED: f32 = 1e-2;

impl Mechanism for Pantograph {
    const NAME: &'static str = "pantograph";
    const JOINTS: usize = 2;
    const DIMENSION_NAMES: &'static [&'static str] = &["near_m", "far_m", "base_m", "centre_x_m", "centre_z_m"];

    fn build([near_m, far_m, base_m, centre_x_m, centre_z_m]: [f32; DIMENSIONS]) -> Result<Self, MechanismError> {
        let arms = [near_m, far_m].iter().all(|arm| (0.005..=1.0).contains(arm)) && (0.0..=1.0).contains(&base_m);
        let centre = [centre_x_m, centre_z_m].iter().all(|c| (-2.0..=2.0).contains(c));
        if !(arms && centre) {
            return Err(MechanismError::Arms);
        }
        Ok(Self { near_m, far_m, base_m, centre_m: [centre_x_m, centre_z_m], jacobian_m: [[0.0; 2]; 2] })
    }

    fn tip_m(&mut self, [q1, q2, _]: [f32; 3]) -> Option<Vector3<f32>> {
        self.jacobian_m = [[0.0; 2]; 2]; // no torque without a valid pose
        let ((s1, c1), (s2, c2)) = (sin_cos(q1), sin_cos(q2));
        let elbow = [self.near_m * c1, self.near_m * s1];
        let other = [self.near_m * c2 - self.base_m, self.near_m * s2];
        // the tip lies above the midpoint between the elbows
        let across = [other[0] - elbow[0], other[1] - elbow[1]];
        let square = across[0] * across[0] + across[1] * across[1];
        let height_square = self.far_m * self.far_m - 0.25 * square;
        if !(square > FOLDED * self.far_m * self.far_m && height_square > 1e-3 * self.far_m * self.far_m) {
            return None; // stretched or folded: the tip's direction of motion is undetermined, and torques are unbounded
        }
        let rise = square_root(height_square / square);
        let tip = [elbow[0] + 0.5 * across[0] + rise * across[1], elbow[1] + 0.5 * across[1] - rise * across[0]];
        // both distal arms keep their length: (tip - elbow) . tip' = (tip - elbow) . elbow', and
        // likewise for the other elbow
        let (u, v) = ([tip[0] - elbow[0], tip[1] - elbow[1]], [tip[0] - other[0], tip[1] - other[1]]);
        let determinant = u[0] * v[1] - u[1] * v[0];
        let turned = self.near_m * (u[1] * c1 - u[0] * s1) / determinant;
        let other_turned = self.near_m * (v[1] * c2 - v[0] * s2) / determinant;
        self.jacobian_m = [[v[1] * turned, -u[1] * other_turned], [-v[0] * turned, u[0] * other_turned]];
        Some(Vector3::new(tip[0] - self.centre_m[0], 0.0, tip[1] - self.centre_m[1]))
    }

    fn torques_n_m(&self, force_n: Vector3<f32>) -> [f32; 3] {
        let [x, z] = self.jacobian_m;
        [x[0] * force_n.x + z[0] * force_n.z, x[1] * force_n.x + z[1] * force_n.z, 0.0]
    }

    fn reaches(&self, tip_m: Vector3<f32>) -> bool {
        let (x, z) = (tip_m.x + self.centre_m[0], tip_m.z + self.centre_m[1]);
        let (most, least) = (self.near_m + self.far_m, self.near_m - self.far_m);
        // above the motors, with the arms of neither side stretched or folded
        z > 0.0
            && [x, x + self.base_m].into_iter().all(|x| {
                let square = x * x + z * z;
                square < most * most && square > least * least
            })
    }
}
