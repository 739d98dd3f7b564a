//! Orientation of the probe, for devices that measure it.

use palpate::BuildError;

use super::HapticSession;

impl HapticSession {
    /// Turns the probe about its tip from the next tick on. `orientation` is its rotation from the
    /// upright pose, in which its axis is the outward direction at the site: a unit quaternion
    /// x, y, z, w in the scene's frame. It replaces the scene's tilt and holds until the next call;
    /// a device that measures it calls this before each tick. Positions are then those of the point
    /// of the turned probe that is lowest when it is upright. The probe turns no faster than its
    /// farthest point may sink into the tissue. Damping and friction act on the displacement of
    /// that point alone, not on the rotation.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`]: the quaternion is not one, or tilts the probe by more than 45
    /// degrees, or a law answers; nothing changes then.
    pub fn turn(&mut self, orientation: [f32; 4]) -> Result<(), BuildError> {
        self.tissue.turn(orientation)
    }
}
