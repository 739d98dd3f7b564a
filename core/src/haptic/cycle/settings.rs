//! Settings of the loop, in SI and ticks.

use crate::fault::BuildError;
use crate::haptic::account::AccountSettings;
use crate::haptic::damping::DampingSettings;
use crate::haptic::device::DeviceSpec;
use crate::haptic::limits::LoopLimitSettings;
use crate::haptic::{Range, each_within};

/// Conditions for arming, and the ramps with which a force begins and ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmingSettings {
    /// Arming continues only below this model force [N].
    pub weak_n: f32,
    /// Arming continues only below this speed of the probe [m/s].
    pub slow_m_per_s: f32,
    /// Calm ticks in a row that arming and clearing a fault require.
    pub calm_ticks: u16,
    /// Rise of the gain per tick after arming (1), in free space: one over the ticks of ramp-in.
    pub ramp_in_per_tick: f32,
    /// Fall of the relief gain per tick while the force is at its limit (1).
    pub relief_per_tick: f32,
    /// Smallest relief gain (1).
    pub least_relief: f32,
    /// Ticks of silence after which the host counts as lost.
    pub silence_ticks: u16,
    /// Ticks within which `SafeRamp` brings any force to zero.
    pub ramp_ticks: u16,
}

/// Ranges of the settings.
/// Source: chosen; around the default; a silent host ends every force within 145 ticks at most.
static RANGES: [Range; 8] = [
    ("arming.weak_n", f32::MIN_POSITIVE, 0.5),
    ("arming.slow_m_per_s", f32::MIN_POSITIVE, 0.5),
    ("arming.calm_ticks", 4.0, 10_000.0),
    ("arming.ramp_in_per_tick", 1e-5, 0.02),
    ("arming.relief_per_tick", 1e-5, 0.02),
    ("arming.least_relief", 0.0, 0.9),
    ("arming.silence_ticks", 1.0, 20.0),
    ("arming.ramp_ticks", 1.0, 125.0),
];

impl ArmingSettings {
    /// Arming requires a force below 0.2 N and a speed below 0.5 m/s for 100 ticks; the gain is
    /// full after 500 ticks outside; a silent host counts as lost after 20 ticks, and any force is
    /// zero 120 ticks later.
    /// Source: 0.2 N as in CHAI3D, which waits for a small force. The ticks are chosen so that a
    /// silent host ends every force within 150 ms (SAFETY.md), the gains so that they change over
    /// half a second and a second.
    pub const DEFAULT: Self = Self {
        weak_n: 0.2,
        slow_m_per_s: 0.5,
        calm_ticks: 100,
        ramp_in_per_tick: 1.0 / 500.0,
        relief_per_tick: 1.0 / 1000.0,
        least_relief: 0.5,
        silence_ticks: 20,
        ramp_ticks: 120,
    };

    /// Checks every number.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the first number out of its range.
    pub fn check(&self) -> Result<(), BuildError> {
        let ticks = [self.calm_ticks, self.silence_ticks, self.ramp_ticks].map(f32::from);
        let [calm, silence, ramp] = ticks;
        let (ramp_in, relief) = (self.ramp_in_per_tick, self.relief_per_tick);
        each_within(&RANGES, [self.weak_n, self.slow_m_per_s, calm, ramp_in, relief, self.least_relief, silence, ramp])
    }
}

impl Default for ArmingSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Everything that the loop is built from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Period of the loop, the tick [s].
    pub tick_s: f32,
    /// Limits, from the device's profile.
    pub limits: LoopLimitSettings,
    /// Gains of the damping in contact.
    pub damping: DampingSettings,
    /// Energy that the hand may be given.
    pub account: AccountSettings,
    /// Arming and ramps.
    pub arming: ArmingSettings,
}

impl Settings {
    /// Settings that are safe on any tissue with this device at 1 kHz: the damping matches the
    /// device's delay, and the limits do not exceed its largest force.
    #[must_use]
    pub fn safe(device: &DeviceSpec) -> Self {
        let tick_s = 1e-3;
        let limits = LoopLimitSettings::DESKTOP;
        let max_force_n = if device.max_force_n < limits.max_force_n { device.max_force_n } else { limits.max_force_n };
        Self {
            tick_s,
            limits: LoopLimitSettings { max_force_n, ..limits },
            damping: DampingSettings::safe(device.delay_s(tick_s), tick_s),
            account: AccountSettings::DEFAULT,
            arming: ArmingSettings::DEFAULT,
        }
    }
}
