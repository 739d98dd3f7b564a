//! Scales the force: gains between 0 and 1, and the maximum force of the mode.

use super::{Cycle, Telemetry};
use crate::fault::ClampFlags;
use crate::haptic::deadline;
use crate::haptic::length;
use crate::haptic::mode::Mode;

impl Cycle {
    /// Product of all gains (1).
    pub(super) fn gain(&mut self, record: &mut Telemetry) -> f32 {
        if !self.touched {
            let ramp = self.ramp + self.arming.ramp_in_per_tick;
            self.ramp = if ramp < 1.0 { ramp } else { 1.0 };
            self.relief = 1.0;
        } else if self.limiter.strained(&self.limits) {
            let relief = self.relief - self.arming.relief_per_tick;
            self.relief = if relief > self.arming.least_relief { relief } else { self.arming.least_relief };
        }
        let gain = self.ramp * self.relief * self.stillness.gain();
        if gain < 1.0 {
            record.limiters.set(ClampFlags::GAIN);
        }
        if self.observer.gain() < 1.0 {
            record.limiters.set(ClampFlags::ENERGY);
        }
        gain * self.observer.gain()
    }

    /// Maximum force that the mode allows [N]. A force that fades because the hand is at rest does
    /// not rise. In `SafeRamp` the maximum falls to zero in a fixed time and never rises.
    pub(super) fn cap_n(&self) -> f32 {
        match self.mode() {
            Mode::Active | Mode::Degraded if self.stillness.fades() => length(&self.limiter.last_n()),
            Mode::Active | Mode::Degraded => self.limits.values().max_force_n,
            Mode::SafeRamp => {
                let ticks_left = u32::from(self.arming.ramp_ticks).saturating_sub(self.machine.ticks());
                let falling_n = self.ramp_from_n * (ticks_left as f32 * self.per_ramp);
                let last_n = length(&self.limiter.last_n());
                if falling_n < last_n { falling_n } else { last_n }
            }
            _ => 0.0,
        }
    }

    /// Maximum force after a late tick [N]: half of the last one.
    pub(super) fn half_n(&self, record: &mut Telemetry) -> f32 {
        let (half_n, cap_n) = (deadline::KEPT * length(&self.limiter.last_n()), self.cap_n());
        record.limiters.set(ClampFlags::GAIN);
        if half_n < cap_n { half_n } else { cap_n }
    }
}
