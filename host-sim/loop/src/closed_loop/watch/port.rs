//! Invariants at the port between device and hand, which believe nobody: I11 the energy that the
//! hand is given, I15 shaking that its motion does not explain.
//!
//! They take the device's profile, the geometry of the tissue at rest, and the physics of each
//! tick: where the tip truly was, which force truly acted, and the work it did. No reading, no
//! report and no setting of the loop reaches them.

mod energy;
mod shaking;

pub use energy::{Contact, EnergyWatch, PortBound};

use std::sync::Arc;

use palpate::Vector3;
use palpate::haptic::device::DeviceSpec;

use self::shaking::ShakingWatch;
use super::Broken;
use super::rest_shape::RestShape;

/// Force that counts as none: the rest that an amplifier's lag leaves [N].
const ACTS_N: f64 = 1e-4;

/// Motion and force at the port in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Position of the tip at the end of the tick [m].
    pub at_m: Vector3<f64>,
    /// Force that acted, after delay and lag: its mean over the tick [N].
    pub mean_n: Vector3<f64>,
    /// Work of that force along the way of the tip within the tick [J]; positive if the hand was
    /// given energy.
    pub work_j: f64,
}

/// Checks the port tick by tick.
#[derive(Clone, Debug)]
pub struct PortWatch {
    shape: Arc<dyn RestShape>,
    energy: EnergyWatch,
    shaking: ShakingWatch,
}

impl PortWatch {
    /// Creates the watch of a device over this geometry, before the first tick.
    #[must_use]
    pub fn over(shape: Arc<dyn RestShape>, device: &DeviceSpec) -> Self {
        Self { shape, energy: EnergyWatch::of(device), shaking: ShakingWatch::default() }
    }

    /// Checks a tick.
    ///
    /// # Errors
    /// Returns the first invariant that the tick breaks.
    pub fn check(&mut self, truth: &Truth) -> Result<(), Broken> {
        let acts = truth.mean_n.norm() > ACTS_N;
        let contact = acts || self.energy.in_contact();
        let depth_m = if contact { self.shape.depth_m(&truth.at_m) } else { 0.0 };
        // a tip that is level with the surface is still in contact
        let free = !acts && depth_m == 0.0 && contact && self.shape.outside_m(&truth.at_m) > 0.0;
        let energy = self.energy.check(truth, depth_m, free);
        energy.and(self.shaking.check(truth, depth_m))
    }

    /// The invariant of energy: its bound, and the energy of the contacts so far.
    #[must_use]
    pub fn energy(&self) -> &EnergyWatch {
        &self.energy
    }
}

#[cfg(test)]
mod tests;
