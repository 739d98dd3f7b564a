//! One joint: a lever whose end presses along z, as in a Hapkit or any capstan-driven paddle.

use palpate::Vector3;

use super::{Mechanism, sin_cos};
use crate::probe_in::EncoderCounts;

/// A paddle that turns about the device's y axis; its end lies on x and moves in the x-z plane.
#[derive(Clone, Copy, Debug)]
pub struct Paddle {
    /// Axis to tip [m].
    pub arm_m: f32,
    /// Joint angle of one encoder count [rad], with its sign.
    pub rad_per_count: f32,
    angle_rad: f32,
}

impl Paddle {
    /// A paddle that lies level at zero counts.
    #[must_use]
    pub fn new(arm_m: f32, rad_per_count: f32) -> Self {
        Self { arm_m, rad_per_count, angle_rad: 0.0 }
    }
}

impl Mechanism for Paddle {
    fn tip_m(&mut self, [counts, ..]: [EncoderCounts; 3]) -> Option<Vector3<f32>> {
        self.angle_rad = counts.0 as f32 * self.rad_per_count;
        let (s, c) = sin_cos(self.angle_rad);
        // the device's centre is the level tip
        Some(Vector3::new(self.arm_m * (c - 1.0), 0.0, self.arm_m * s))
    }

    fn torques_n_m(&self, force_n: Vector3<f32>) -> [f32; 3] {
        let (s, c) = sin_cos(self.angle_rad);
        [self.arm_m * (c * force_n.z - s * force_n.x), 0.0, 0.0]
    }
}
