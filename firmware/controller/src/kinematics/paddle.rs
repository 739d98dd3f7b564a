//! One joint: a lever whose end presses along z, as in a Hapkit or any capstan-driven paddle.

use palpate::Vector3;

use super::{DIMENSIONS, Mechanism, MechanismError, sin_cos};

/// A paddle that turns about the device's y axis, so that its end moves in the x-z plane. At an
/// angle of zero the paddle is level along x, and its end is at the device's centre; a positive
/// angle lifts it.
#[derive(Clone, Copy, Debug)]
pub struct Paddle {
    /// Distance from axis to tip [m].
    pub arm_m: f32,
    /// Sine and cosine of the angle as last read.
    turned: (f32, f32),
}

impl Mechanism for Paddle {
    const NAME: &'static str = "paddle";
    const JOINTS: usize = 1;
    const DIMENSION_NAMES: &'static [&'static str] = &["arm_m"];

    fn build([arm_m, ..]: [f32; DIMENSIONS]) -> Result<Self, MechanismError> {
        if !(0.005..=1.0).contains(&arm_m) {
            return Err(MechanismError::Arms);
        }
        Ok(Self { arm_m, turned: (0.0, 1.0) })
    }

    fn tip_m(&mut self, [angle_rad, ..]: [f32; 3]) -> Option<Vector3<f32>> {
        self.turned = sin_cos(angle_rad);
        let (s, c) = self.turned;
        // beyond vertical the paddle would press from the other side
        (c > 0.0).then(|| Vector3::new(self.arm_m * (c - 1.0), 0.0, self.arm_m * s))
    }

    fn torques_n_m(&self, force_n: Vector3<f32>) -> [f32; 3] {
        let (s, c) = self.turned;
        [self.arm_m * (c * force_n.z - s * force_n.x), 0.0, 0.0]
    }

    fn reaches(&self, tip_m: Vector3<f32>) -> bool {
        tip_m.z.abs() < self.arm_m
    }
}
