//! From joints to the probe and back: joint angles become a tip, a force on the hand becomes joint
//! torques.
//!
//! A mechanism answers two questions, and the second with the transpose of the first one's
//! derivative: `tau = J^T F` gives the joints exactly the power that the hand gets, `tau . q' = F .
//! x'`. It applies to the mechanism as it was when the encoders were read.
//!
//! * in: angles of up to three joints [rad] / a force [N], device frame
//! * out: tip [m], device frame / torques [N m]
//! * cost: paddle 60, pantograph some 250 instructions of a Cortex-M4F
//! * may fail: a pantograph that cannot close has no pose, so the sensor counts as failed

mod angle;
mod catalogue;
mod error;
mod paddle;
mod pantograph;
pub mod profile;
mod your_device;

pub use angle::sin_cos;
pub use catalogue::{Kind, Linkage};
pub use error::MechanismError;
pub use paddle::Paddle;
pub use pantograph::Pantograph;
pub use profile::MechanismProfile;
pub use your_device::YourDevice;

use palpate::Vector3;

/// Largest number of dimensions of a mechanism.
pub const DIMENSIONS: usize = 5;

/// A device's geometry.
pub trait Mechanism: Sized {
    /// Name in profile files.
    const NAME: &'static str;

    /// Joints with an encoder and a motor, at most three.
    const JOINTS: usize;

    /// Names of its dimensions in profile files, with their units; at most [`DIMENSIONS`].
    const DIMENSION_NAMES: &'static [&'static str];

    /// Builds the mechanism from its dimensions, in the order of their names; the rest are zero.
    ///
    /// # Errors
    /// [`MechanismError::Arms`], if such a mechanism is impossible.
    fn build(dimensions: [f32; DIMENSIONS]) -> Result<Self, MechanismError>;

    /// Tip for joint angles [rad] in metres, device frame; `None` if the joint angles are
    /// impossible. Remembers the joints for [`Self::torques_n_m`].
    fn tip_m(&mut self, joints_rad: [f32; 3]) -> Option<Vector3<f32>>;

    /// Joint torques that put a force on the hand [N m], for the joints as last read. A force
    /// component for which the mechanism has no joint is left out.
    fn torques_n_m(&self, force_n: Vector3<f32>) -> [f32; 3];

    /// Whether the tip can reach a place [m], device frame, in the directions in which the
    /// mechanism moves. Checked at the corners of the workspace when a profile is loaded.
    fn reaches(&self, tip_m: Vector3<f32>) -> bool;
}
