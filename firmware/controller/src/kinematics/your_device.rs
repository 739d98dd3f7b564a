//! **Bring your own device.** Copy this file, change what the comments say, and name it in
//! `board/`.
//!
//! It stands for a device with three linear axes, each with its own motor and spindle: the simplest
//! one there is. `tests/tests/controller/kinematics_keep_power.rs` holds every mechanism against
//! finite differences and the power balance; add yours there first.

use palpate::Vector3;

use super::Mechanism;
use crate::probe_in::EncoderCounts;

/// 1. What your device is made of, in SI: lengths in metres, angles in radians, with what one
///    encoder count means.
#[derive(Clone, Copy, Debug)]
pub struct YourDevice {
    /// Way of an axis for one encoder count [m], with its sign: positive counts must move the tip
    /// along the device frame's positive axis.
    pub m_per_count: [f32; 3],
    /// Way of an axis for one radian of its motor [m/rad]: the spindle's lead over a turn.
    pub m_per_rad: [f32; 3],
}

impl Mechanism for YourDevice {
    /// 2. Where is the tip? Right-handed frame, x to the operator, y to the operator's right, z up,
    ///    out of the tissue; the origin is where the patch's site will be. Return `None` where the
    ///    joints cannot be: the cycle then takes the sensor as failed, and the force away.
    fn tip_m(&mut self, counts: [EncoderCounts; 3]) -> Option<Vector3<f32>> {
        let [x, y, z] = counts;
        let [per_x, per_y, per_z] = self.m_per_count;
        Some(Vector3::new(x.0 as f32 * per_x, y.0 as f32 * per_y, z.0 as f32 * per_z))
        // 3. If the tip depends on angles, keep what the torques need (see `pantograph.rs`): they
        //    are asked for later in the same tick.
    }

    /// 4. Which torques put `force_n` on the hand? Never guess: it is the transpose of the
    ///    derivative of the tip, `tau_k = sum_i dx_i/dq_k F_i`. Then motors and hand get the same
    ///    power, and the loop's energy account is right.
    fn torques_n_m(&self, force_n: Vector3<f32>) -> [f32; 3] {
        let [x, y, z] = self.m_per_rad;
        [x * force_n.x, y * force_n.y, z * force_n.z]
    }
}

// 5. Its limits go into a `DeviceSpec` (see `port.rs`): the largest force that it gives in
//    *every* direction of its workspace, the workspace's corners, one count at the probe, and how
//    many ticks a force takes to act. Nothing is switched on before they are in range.
// 6. In `board/`: read the encoders, call `tip_m`, put the torques through your amplifiers' scale,
//    and drive the enable line from `Outputs::enabled`.
