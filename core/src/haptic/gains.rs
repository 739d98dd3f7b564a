//! Ramp-in after arming, and relief of a contact whose force stays at its limit.
//!
//! The gain rises in free space only, since a gain that rises while a spring is compressed adds
//! energy to the hand. A contact in which the model's force has been at the limit for longer than
//! `saturated_ticks` is relieved: its gain falls slowly and returns to one after the contact.
//!
//! * in: whether the patch is touched, the model's force [N]
//! * out: force [N] times a gain (0 .. 1)
//! * cost: 30 instructions of a Cortex-M4F, estimated
//! * failures: none; [`ClampFlags::GAIN`] is set

use nalgebra::Vector3;

use super::cycle::ArmingSettings;
use super::seen::{Monitor, Seen, Shaper};
use crate::fault::{ClampFlags, Fault};

/// Share of the square of the limit from which a force counts as being at it (1), for rounding:
/// a clamped force may be a thousandth shorter.
/// Source: derived; 0.999 squared.
const AT_LIMIT: f32 = 0.998;

/// The two gains.
#[derive(Clone, Copy, Debug)]
pub struct Gains {
    arming: ArmingSettings,
    /// Ramp-in gain (1).
    ramp: f32,
    /// Relief gain (1).
    relief: f32,
    /// Ticks in a row in which the model's force was at the limit.
    saturated: u16,
    /// Whether these are too many.
    strained: bool,
}

impl Gains {
    /// Gains before the first arming: no force.
    #[must_use]
    pub fn new(arming: &ArmingSettings) -> Self {
        Self { arming: *arming, ramp: 0.0, relief: 1.0, saturated: 0, strained: false }
    }

    /// Begins the ramp-in, when the loop has armed.
    pub fn begin(&mut self) {
        (self.ramp, self.relief) = (0.0, 1.0);
    }

    /// Relief gain (1).
    #[must_use]
    pub fn relief(&self) -> f32 {
        self.relief
    }

    /// Whether the model's force was at the limit for longer than `saturated_ticks`.
    #[must_use]
    pub fn strained(&self) -> bool {
        self.strained
    }
}

impl Monitor for Gains {
    fn judge(&mut self, seen: &Seen) -> Result<(), Fault> {
        let limits = seen.limits.values();
        let (square, most_n) = (seen.output.force_n.dot(&seen.output.force_n), limits.max_force_n);
        self.saturated = if square >= AT_LIMIT * (most_n * most_n) { self.saturated.saturating_add(1) } else { 0 };
        self.strained = self.saturated > limits.saturated_ticks;
        Ok(())
    }

    fn reset(&mut self) {
        (self.saturated, self.strained) = (0, false);
    }
}

impl Shaper for Gains {
    fn shape(&mut self, force_n: Vector3<f32>, seen: &Seen, flags: &mut ClampFlags) -> Vector3<f32> {
        if !seen.touched {
            let ramp = self.ramp + self.arming.ramp_in_per_tick;
            self.ramp = if ramp < 1.0 { ramp } else { 1.0 };
            self.relief = 1.0;
        } else if self.strained {
            let relief = self.relief - self.arming.relief_per_tick;
            self.relief = if relief > self.arming.least_relief { relief } else { self.arming.least_relief };
        }
        let gain = self.ramp * self.relief;
        if gain < 1.0 {
            flags.set(ClampFlags::GAIN);
        }
        force_n * gain
    }

    fn reset(&mut self) {}
}
