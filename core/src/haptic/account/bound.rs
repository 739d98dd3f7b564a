//! The energy that a hand can be given at most (SAFETY.md derives it).

use super::{AccountSettings, EnergyAccount};
use crate::haptic::HAND_M_PER_S2;
use crate::haptic::device::DeviceSpec;

/// Variation of the force, rises and falls, for which the refill pays [N/s].
/// Source: measured (`palpate faults --hands`); the force of a hand that kneads or slides on counts
/// of 55 to 80 um varies by 40 to 150 N/s. With 100, a hand on counts of 80 um loses its force.
const VARIATION_N_PER_S: f32 = 150.0;

/// The most energy that a hand can be given beyond what it gave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyBound {
    /// At once, by a motion as sharp as any of a hand's [J].
    pub at_once_j: f32,
    /// For as long as the loop runs [W].
    pub lasting_w: f32,
}

impl EnergyBound {
    /// The most energy that any contacts within this time can give [J].
    #[must_use]
    pub fn within_j(&self, seconds: f32) -> f32 {
        self.at_once_j + self.lasting_w * seconds
    }
}

impl EnergyAccount {
    /// The most that a hand on this device can be given beyond what it gave: the allowance, what is
    /// on its way when the hand turns more sharply than the account reserves for, and, for as long
    /// as the loop runs, the refill (SAFETY.md). A device that misses so many periods in a row
    /// holds its force through them, so that each is one more tick of delay.
    #[must_use]
    #[inline]
    pub fn bound(settings: &AccountSettings, device: &DeviceSpec, tick_s: f32, missed: u8) -> EnergyBound {
        let most_n = device.max_force_n;
        let lag = device.lag_s / tick_s;
        let ticks = f32::from(device.delay_ticks) + 1.0 + f32::from(missed) + lag;
        let window = f32::from(DeviceSpec::MOST_DELAY_TICKS);
        // as if nothing of the acceleration were reserved for, so that the bound is the profile's
        // alone
        let sharp_m_per_s2 = Self::sharp_m_per_s2(device);
        // the second term is the tail of the lag, which outlasts a delay of the same length
        let way_m = sharp_m_per_s2 * tick_s * tick_s * 0.5 * (ticks * (ticks + window) + lag * (lag + 1.0));
        EnergyBound {
            at_once_j: settings.allowance_j + most_n * (way_m + device.count_m),
            // a rise of the force is half of its variation
            lasting_w: settings.refill_w + 0.5 * VARIATION_N_PER_S * device.count_m,
        }
    }

    /// The sharpest acceleration of a probe, by a hand and by the device's largest force [m/s^2].
    pub(super) fn sharp_m_per_s2(device: &DeviceSpec) -> f32 {
        HAND_M_PER_S2 + device.max_force_n / device.mass_kg
    }
}
