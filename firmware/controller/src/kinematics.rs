//! Conversion between joints and probe: from joint angles to the tip position, and from a force on
//! the hand to joint torques.
//!
//! The torques follow from the transpose of the Jacobian of the tip position: with `tau = J^T F`
//! the joints deliver exactly the power that the hand receives, `tau . q' = F . x'`. J is evaluated
//! at the joint angles that were read last.
//!
//! * in: angles of up to three joints [rad] / a force [N], device frame
//! * out: tip [m], device frame / torques [N m]
//! * cost: 60 instructions of a Cortex-M4F for a paddle, some 250 for a pantograph
//! * failures: joint angles at which a pantograph cannot close count as a failed sensor

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

/// Kinematics of a device: tip position from joint angles, and joint torques from a force.
pub trait Mechanism: Sized {
    /// Name in profile files.
    const NAME: &'static str;

    /// Number of joints, each with an encoder and a motor; at most three.
    const JOINTS: usize;

    /// Names of the dimensions in profile files, with their units; at most [`DIMENSIONS`].
    const DIMENSION_NAMES: &'static [&'static str];

    /// Builds the mechanism from its dimensions, in the order of their names; unused entries are
    /// zero.
    ///
    /// # Errors
    /// [`MechanismError::Arms`], if such a mechanism is impossible.
    fn build(dimensions: [f32; DIMENSIONS]) -> Result<Self, MechanismError>;

    /// Tip position [m], device frame, for joint angles [rad]; `None` if the joint angles are
    /// impossible. Stores the joint angles for [`Self::torques_n_m`].
    fn tip_m(&mut self, joints_rad: [f32; 3]) -> Option<Vector3<f32>>;

    /// Joint torques [N m] that exert a force on the hand, at the joint angles as last read. A
    /// force component for which the mechanism has no joint is ignored.
    fn torques_n_m(&self, force_n: Vector3<f32>) -> [f32; 3];

    /// Whether the tip can reach a position [m], device frame, in the directions in which the
    /// mechanism moves. Checked at the corners of the workspace when a profile is loaded.
    fn reaches(&self, tip_m: Vector3<f32>) -> bool;
}
