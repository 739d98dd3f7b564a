//! Settings of the energy account and their ranges.

use crate::fault::BuildError;
use crate::haptic::{HAND_M_PER_S2, Range, each_within};

/// Settings of the account.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccountSettings {
    /// Energy that the hand may be given beyond what it gave [J].
    pub allowance_j: f32,
    /// Rate at which the allowance is restored [W].
    pub refill_w: f32,
    /// Acceleration of the probe by the hand that the account reserves for [m/s^2].
    pub acceleration_m_per_s2: f32,
    /// Share of the acceleration of the bare handle by a force that the account reserves for (1):
    /// the hand moves with the handle.
    pub handle_share: f32,
}

/// Ranges of the settings.
/// Source: chosen; from zero to [`AccountSettings::HIGHEST`], and to the acceleration of a hand.
static RANGES: [Range; 4] = [
    ("account.allowance_j", 0.0, AccountSettings::HIGHEST.allowance_j),
    ("account.refill_w", 0.0, AccountSettings::HIGHEST.refill_w),
    ("account.acceleration_m_per_s2", 0.0, HAND_M_PER_S2),
    ("account.handle_share", 0.0, 1.0),
];

impl AccountSettings {
    /// 20 uJ and 30 uW, which are not felt; 3 m/s^2 and seven tenths of the bare handle's
    /// acceleration. `palpate faults --trade` measures what other values cost: at five ticks a
    /// share of zero lets out half as much again, and 25 m/s^2 take away a tenth of the force.
    /// With 0.85 a probe that is pressed into a side shakes at one tick
    /// (`two_thousand_paths_break_no_invariant_and_honest_motion_trips_nothing`).
    /// Source: that command for acceleration and share. The others are chosen: the allowance is a
    /// fifth of the 0.1 mJ from which that command calls a contact one that creates energy.
    pub const DEFAULT: Self = Self { allowance_j: 20e-6, refill_w: 30e-6, acceleration_m_per_s2: 3.0, handle_share: 0.7 };
    /// An account that never runs out, for other controllers that are compared with ours.
    /// Source: chosen; more than any contact takes.
    pub const HIGHEST: Self = Self { allowance_j: 1e3, refill_w: 1e3, acceleration_m_per_s2: 0.0, handle_share: 0.0 };

    /// Checks every setting.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the setting.
    #[inline]
    pub fn check(&self) -> Result<(), BuildError> {
        each_within(&RANGES, [self.allowance_j, self.refill_w, self.acceleration_m_per_s2, self.handle_share])
    }
}
