//! **Bring your own device.** Copy this file, follow its numbered comments, and add your device in
//! `catalogue.rs`.
//!
//! The device here is the simplest possible one: three linear axes, each with its own motor and
//! spindle. Copy its test, `tests/tests/controller/your_device.rs`, as well: it compares the
//! torques with finite differences of the tip position, and loads a profile, which you copy from
//! `firmware/controller/devices/your-device.toml`.

use palpate::Vector3;

use super::{DIMENSIONS, Mechanism, MechanismError};

/// 1. The dimensions of your device, in SI: lengths in metres, angles in radians. Encoders, gears,
///    amplifiers and signs do not belong here: a joint is an angle and a torque.
#[derive(Clone, Copy, Debug)]
pub struct YourDevice {
    /// Displacement of an axis per radian of its joint [m/rad]: the spindle's lead over a turn.
    pub lead_m_per_rad: [f32; 3],
}

impl Mechanism for YourDevice {
    /// 2. Its name in profile files, its number of joints, and the names of its dimensions in
    ///    profile files.
    const NAME: &'static str = "your-device";
    const JOINTS: usize = 3;
    const DIMENSION_NAMES: &'static [&'static str] = &["lead_x_m_per_rad", "lead_y_m_per_rad", "lead_z_m_per_rad"];

    /// 3. Which dimensions are impossible? NaN is outside every range.
    fn build([x, y, z, ..]: [f32; DIMENSIONS]) -> Result<Self, MechanismError> {
        let lead_m_per_rad = [x, y, z];
        if !lead_m_per_rad.iter().all(|lead| (1e-5..=0.2).contains(lead)) {
            return Err(MechanismError::Arms);
        }
        Ok(Self { lead_m_per_rad })
    }

    /// 4. Where is the tip? Right-handed frame, x to the operator, y to the operator's right, z up,
    ///    out of the tissue; the origin is where the patch's site will be. Return `None` if the
    ///    joint angles are impossible: the cycle then treats the sensor as failed and removes the
    ///    force.
    fn tip_m(&mut self, [x, y, z]: [f32; 3]) -> Option<Vector3<f32>> {
        let [per_x, per_y, per_z] = self.lead_m_per_rad;
        Some(Vector3::new(x * per_x, y * per_y, z * per_z))
        // If the tip depends on angles, store what the torques need (see `pantograph.rs`): they are
        // computed later in the same tick.
    }

    /// 5. Which torques put `force_n` on the hand? Use the transpose of the Jacobian of the tip
    ///    position, `tau_k = sum_i dx_i/dq_k F_i`: the motors then deliver the power that the hand
    ///    receives, and the loop's energy balance is correct.
    fn torques_n_m(&self, force_n: Vector3<f32>) -> [f32; 3] {
        let [x, y, z] = self.lead_m_per_rad;
        [x * force_n.x, y * force_n.y, z * force_n.z]
    }

    /// 6. Can the tip get there? A profile whose workspace extends beyond the mechanism's reach is
    ///    refused.
    fn reaches(&self, _tip_m: Vector3<f32>) -> bool {
        true
    }
}
