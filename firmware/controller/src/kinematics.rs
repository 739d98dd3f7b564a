//! From joints to the probe and back: a reading of the encoders becomes a tip, a force on the hand
//! becomes joint torques.
//!
//! A mechanism answers two questions, and the second with the transpose of the first one's
//! derivative: `tau = J^T F` gives the joints exactly the power that the hand gets, `tau . q' = F .
//! x'`. That holds for the mechanism as it was when the encoders were read.
//!
//! * in: counts of up to three encoders / a force [N], device frame
//! * out: tip [m], device frame / torques [N m]
//! * cost: paddle 60, pantograph some 250 instructions of a Cortex-M4F
//! * may fail: a pantograph that cannot close is no pose: the sensor has failed

mod angle;
mod paddle;
mod pantograph;
mod your_device;

pub use angle::sin_cos;
pub use paddle::Paddle;
pub use pantograph::Pantograph;
pub use your_device::YourDevice;

use palpate::Vector3;

use crate::probe_in::EncoderCounts;

/// A device's geometry.
pub trait Mechanism {
    /// Tip for what the encoders count [m], device frame; `None` if the joints cannot be so.
    /// Remembers the joints for [`Self::torques_n_m`].
    fn tip_m(&mut self, counts: [EncoderCounts; 3]) -> Option<Vector3<f32>>;

    /// Joint torques that put a force on the hand [N m], for the joints as last read. A force that
    /// the mechanism has no joint for is left out.
    fn torques_n_m(&self, force_n: Vector3<f32>) -> [f32; 3];
}
