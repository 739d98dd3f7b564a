//! A mechanism as data: the part of a device profile that describes it, and a check that the
//! mechanism can move as the profile says.

use palpate::Vector3;
use palpate::haptic::device::DeviceSpec;
use serde::{Deserialize, Serialize};

use super::{DIMENSIONS, Kind, Linkage, MechanismError};

/// Joints, motors and dimensions of a device. Entries for joints that the kind does not have are
/// zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MechanismProfile {
    /// Kind of the mechanism.
    pub kind: Kind,
    /// Joint angle per encoder count [rad], including gear and sign.
    pub rad_per_count: [f32; 3],
    /// Joint torque at the converter's largest code [N m], including torque constant, gear and
    /// sign.
    pub full_scale_n_m: [f32; 3],
    /// Joint angles in the home pose [rad].
    pub home_rad: [f32; 3],
    /// Dimensions in the order of [`super::Mechanism::DIMENSION_NAMES`].
    pub dimensions: [f32; DIMENSIONS],
    /// Whether the encoders count from their position at power-on: the board then does not arm
    /// before the device has been homed.
    pub homing: bool,
}

/// Largest relative difference between the computed displacement of the probe per count and the
/// profile's `count_m` (1).
const COUNT_TOLERANCE: f32 = 0.1;

impl MechanismProfile {
    /// Builds the mechanism.
    ///
    /// # Errors
    /// Fails with [`MechanismError::Arms`] if a mechanism with these dimensions is impossible.
    pub fn build(&self) -> Result<Linkage, MechanismError> {
        self.kind.build(self.dimensions)
    }

    /// Checks that the mechanism is possible and has the workspace, force and `count_m` of the
    /// device.
    ///
    /// # Errors
    /// [`MechanismError`] names the first condition that is not met.
    #[inline(never)]
    pub fn check(&self, device: &DeviceSpec) -> Result<(), MechanismError> {
        let mut linkage = self.build()?;
        let joints = self.kind.joints();
        let each = |numbers: &[f32; 3], least: f32, most: f32| {
            numbers.iter().enumerate().all(
                |(joint, number)| {
                    if joint < joints { (least..=most).contains(&number.abs()) } else { *number == 0.0 }
                },
            )
        };
        if !each(&self.rad_per_count, 1e-7, 0.1) {
            return Err(MechanismError::Encoder);
        }
        if !each(&self.full_scale_n_m, 1e-4, 100.0) {
            return Err(MechanismError::Motor);
        }
        if !each(&self.home_rad, 0.0, 6.3) {
            return Err(MechanismError::Home);
        }
        let (low_m, high_m) = (device.workspace_low_m, device.workspace_high_m);
        let home_m = linkage.tip_m(self.home_rad).ok_or(MechanismError::Home)?;
        if !home_m.iter().zip(low_m.iter().zip(high_m.iter())).all(|(at, (low, high))| low <= at && at <= high) {
            return Err(MechanismError::Home);
        }
        let corners = [low_m.x, high_m.x].map(|x| [low_m.z, high_m.z].map(|z| Vector3::new(x, 0.0, z)));
        if !corners.iter().flatten().all(|corner| linkage.reaches(*corner)) {
            return Err(MechanismError::Reach);
        }
        let levers_m = levers_m(&linkage);
        let weak = |lever: f32, full: f32| lever.abs() * device.max_force_n > full.abs();
        if levers_m.iter().any(|levers| levers.iter().zip(self.full_scale_n_m).any(|(lever, full)| weak(*lever, full))) {
            return Err(MechanismError::Force);
        }
        let count_m = self.coarsest_count_m(&levers_m);
        if (device.count_m - count_m).abs() > COUNT_TOLERANCE * count_m {
            return Err(MechanismError::Count);
        }
        Ok(())
    }

    /// Largest displacement of the tip along an axis by one count of every encoder, in the home
    /// pose [m]; `None` if the mechanism or its home pose is impossible. A reading is off by half
    /// of it at most.
    #[must_use]
    pub fn count_m(&self) -> Option<f32> {
        let mut linkage = self.build().ok()?;
        linkage.tip_m(self.home_rad)?;
        Some(self.coarsest_count_m(&levers_m(&linkage)))
    }

    fn coarsest_count_m(&self, levers_m: &[[f32; 3]; 3]) -> f32 {
        let along = |axis: &[f32; 3]| axis.iter().zip(self.rad_per_count).map(|(lever_m, step)| (lever_m * step).abs()).sum();
        levers_m.iter().map(along).fold(0.0_f32, f32::max)
    }
}

/// Displacement of the tip along x, y and z per joint angle [m], at the joint angles as last read.
fn levers_m(linkage: &Linkage) -> [[f32; 3]; 3] {
    [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| linkage.torques_n_m(axis))
}
