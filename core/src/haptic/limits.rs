//! Limits between a model and a hand: which poses are accepted, and which force may be output.
//!
//! No limit can be switched off: a limit is a number that has to be in its range, and one
//! [`LoopLimits`] can be derived from another only by lowering values. "Lower" is "stricter" for
//! every one of them.

mod freeze;
mod pose;

pub use pose::{Pose, PoseGate};

use nalgebra::Vector3;

use super::device::DeviceSpec;
use super::within;
use crate::fault::BuildError;

/// Limits as a profile states them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopLimitSettings {
    /// Maximum force on the hand [N].
    pub max_force_n: f32,
    /// Fastest growth of the force [N/s]. A falling force is not limited: a force held beyond its
    /// time would push the hand out with more energy than it brought in.
    pub max_slew_n_per_s: f32,
    /// Largest plausible speed of the probe [m/s].
    pub max_speed_m_per_s: f32,
    /// Number of readings in a row beyond `max_speed_m_per_s` that is a fault while a force acts.
    /// Fewer are treated as glitches, and the last good pose is held.
    pub odd_poses: u16,
    /// Greatest age of a pose that is still rendered [ticks].
    pub max_age_ticks: u16,
    /// Distance outside the workspace up to which a pose is accepted, as a share of the workspace's
    /// size (1).
    pub workspace_margin: f32,
    /// A model force more than this many times that of the device is implausible (1).
    pub implausible_ratio: f32,
    /// Number of ticks in a row with an implausible force that is a fault.
    pub implausible_ticks: u16,
    /// Number of ticks in a row at `max_force_n` after which the mode becomes `Degraded`.
    pub saturated_ticks: u16,
}

/// Lower bound of a limit: the squares of smaller values underflow, and a zero force would exceed
/// it.
/// Source: chosen; no sensor shows a micronewton or a micrometre per second.
const SMALL: f32 = 1e-6;
/// Name and lower bound of every limit.
/// Source: chosen; counts begin at one, the others at [`SMALL`] or at what changes nothing.
static LEAST: [(&str, f32); 9] = [
    ("limits.max_force_n", SMALL),
    ("limits.max_slew_n_per_s", SMALL),
    ("limits.max_speed_m_per_s", SMALL),
    ("limits.odd_poses", 1.0),
    ("limits.max_age_ticks", 1.0),
    ("limits.workspace_margin", 0.0),
    ("limits.implausible_ratio", 1.0),
    ("limits.implausible_ticks", 1.0),
    ("limits.saturated_ticks", 1.0),
];

impl LoopLimitSettings {
    /// Limits for a desktop stylus of 3.3 N, and the default: 3 N, 500 N/s, a fault at the second
    /// reading in a row beyond 1.5 m/s, poses up to two ticks old, the workspace enlarged by a
    /// tenth.
    /// Source: the profile `touch` for the force; the others are chosen, the slew so that the whole
    /// force is there after six ticks.
    pub const DESKTOP: Self = Self {
        max_force_n: 3.0,
        max_slew_n_per_s: 500.0,
        max_speed_m_per_s: 1.5,
        odd_poses: 2,
        max_age_ticks: 2,
        workspace_margin: 0.1,
        implausible_ratio: 5.0,
        implausible_ticks: 10,
        saturated_ticks: 200,
    };
    /// Upper bounds of the limits on any device.
    /// Source: chosen; one and a half to ten times the values for a desktop stylus.
    pub const HIGHEST: Self = Self {
        max_force_n: DeviceSpec::MOST_FORCE_N,
        max_slew_n_per_s: 5_000.0,
        max_speed_m_per_s: 3.0,
        odd_poses: 3,
        max_age_ticks: 5,
        workspace_margin: 0.25,
        implausible_ratio: 10.0,
        implausible_ticks: 20,
        saturated_ticks: 1_000,
    };

    /// Every limit, in the order of [`LEAST`].
    fn numbers(&self) -> [f32; 9] {
        [
            self.max_force_n,
            self.max_slew_n_per_s,
            self.max_speed_m_per_s,
            f32::from(self.odd_poses),
            f32::from(self.max_age_ticks),
            self.workspace_margin,
            self.implausible_ratio,
            f32::from(self.implausible_ticks),
            f32::from(self.saturated_ticks),
        ]
    }

    /// Checks that every limit is between its lower bound and its value in `highest`. NaN, negative
    /// and infinite values are refused, and so is zero, except as a workspace margin.
    #[inline(never)]
    fn check_below(&self, highest: &Self) -> Result<(), BuildError> {
        let bounds = LEAST.iter().zip(highest.numbers());
        bounds.zip(self.numbers()).try_for_each(|((&(limit, min), max), value)| BuildError::within(limit, value, min, max))
    }
}

impl Default for LoopLimitSettings {
    fn default() -> Self {
        Self::DESKTOP
    }
}

/// Limits in effect. They are built once for a device; after that they can only become stricter.
#[derive(Clone, Copy, Debug)]
pub struct LoopLimits {
    values: LoopLimitSettings,
    /// Force of the model that is implausible [N]. It does not follow a lowered limit: the tissue
    /// is as stiff as before.
    pub(super) implausible_n: f32,
    /// Largest growth of the force per tick [N].
    pub(super) slew_n: f32,
    /// Largest plausible displacement per tick [m], without the encoder's share.
    displacement_m: f32,
    /// Two counts [m]: the quantisation error of a displacement.
    counts_m: f32,
    low_m: Vector3<f32>,
    high_m: Vector3<f32>,
    tick_s: f32,
    ticks_per_s: f32,
    device: DeviceSpec,
}

impl LoopLimits {
    /// Checks the values against the device and against [`LoopLimitSettings::HIGHEST`]. On a device
    /// that was not commissioned the force is at most [`DeviceSpec::UNCOMMISSIONED_N`], whatever
    /// the values say: a wrong sign, unit or frame then pushes no harder than that.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the limit; NaN is out of every range.
    #[inline]
    pub fn build(values: &LoopLimitSettings, device: &DeviceSpec, tick_s: f32) -> Result<Self, BuildError> {
        device.check()?;
        within(&[("tick_s", tick_s, 1e-4, 1e-2)])?;
        values.check_below(&LoopLimitSettings { max_force_n: device.max_force_n, ..LoopLimitSettings::HIGHEST })?;
        let most_n = DeviceSpec::UNCOMMISSIONED_N;
        let mut values = *values;
        if !device.commissioned && values.max_force_n > most_n {
            values.max_force_n = most_n;
        }
        Ok(Self::derive(&values, device, tick_s))
    }

    /// Replaces the limits by others, none of which may be looser than now.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the limit that would be higher than it is, or is NaN;
    /// nothing changes then.
    #[inline]
    pub fn lowered(&self, values: &LoopLimitSettings) -> Result<Self, BuildError> {
        values.check_below(&self.values)?;
        Ok(Self::derive(values, &self.device, self.tick_s))
    }

    /// Derives the limits per tick. It is never inlined, because neither of its two callers runs in
    /// a tick.
    #[inline(never)]
    fn derive(values: &LoopLimitSettings, device: &DeviceSpec, tick_s: f32) -> Self {
        let margin_m = (device.workspace_high_m - device.workspace_low_m) * values.workspace_margin;
        Self {
            values: *values,
            implausible_n: values.implausible_ratio * device.max_force_n,
            slew_n: values.max_slew_n_per_s * tick_s,
            displacement_m: values.max_speed_m_per_s * tick_s,
            counts_m: 2.0 * device.count_m,
            low_m: device.workspace_low_m - margin_m,
            high_m: device.workspace_high_m + margin_m,
            tick_s,
            ticks_per_s: 1.0 / tick_s,
            device: *device,
        }
    }

    /// Values of the limits.
    #[must_use]
    pub fn values(&self) -> &LoopLimitSettings {
        &self.values
    }

    /// Ticks per second [1/s].
    #[must_use]
    pub fn ticks_per_s(&self) -> f32 {
        self.ticks_per_s
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub fn device() -> DeviceSpec {
        DeviceSpec {
            max_force_n: 3.3,
            workspace_low_m: Vector3::new(-0.08, -0.06, -0.06),
            workspace_high_m: Vector3::new(0.08, 0.06, 0.06),
            count_m: 55e-6,
            delay_ticks: 1,
            lag_s: 0.0,
            mass_kg: 0.045,
            stiffness_ceiling_n_per_m: 1e5,
            commissioned: true,
        }
    }

    pub fn limits() -> LoopLimits {
        LoopLimits::build(&LoopLimitSettings::DESKTOP, &device(), 1e-3).unwrap()
    }

    /// Every scalar limit, to be set one at a time.
    const SCALARS: [fn(&mut LoopLimitSettings) -> &mut f32; 5] = [
        |v| &mut v.max_force_n,
        |v| &mut v.max_slew_n_per_s,
        |v| &mut v.max_speed_m_per_s,
        |v| &mut v.workspace_margin,
        |v| &mut v.implausible_ratio,
    ];
    const COUNTS: [fn(&mut LoopLimitSettings) -> &mut u16; 4] =
        [|v| &mut v.odd_poses, |v| &mut v.max_age_ticks, |v| &mut v.implausible_ticks, |v| &mut v.saturated_ticks];

    #[test]
    fn what_is_no_limit_is_refused() {
        for pick in SCALARS {
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 1e9] {
                let mut values = LoopLimitSettings::DESKTOP;
                *pick(&mut values) = bad;
                assert!(LoopLimits::build(&values, &device(), 1e-3).is_err(), "{values:?}");
                assert!(limits().lowered(&values).is_err(), "{values:?}");
            }
        }
        for pick in COUNTS {
            for bad in [0, u16::MAX] {
                let mut values = LoopLimitSettings::DESKTOP;
                *pick(&mut values) = bad;
                assert!(LoopLimits::build(&values, &device(), 1e-3).is_err() && limits().lowered(&values).is_err(), "{values:?}");
            }
        }
        let beyond = LoopLimitSettings { max_force_n: 3.4, ..LoopLimitSettings::DESKTOP };
        assert!(LoopLimits::build(&beyond, &device(), 1e-3).is_err(), "more than the device has");
        let nowhere = DeviceSpec { workspace_high_m: Vector3::repeat(f32::NAN), ..device() };
        assert!(LoopLimits::build(&LoopLimitSettings::DESKTOP, &nowhere, 1e-3).is_err());
    }

    #[test]
    fn a_device_that_was_not_commissioned_has_half_a_newton_at_most() {
        let unknown = DeviceSpec { commissioned: false, ..device() };
        let limits = LoopLimits::build(&LoopLimitSettings::DESKTOP, &unknown, 1e-3).unwrap();
        assert_eq!(limits.values().max_force_n, 0.5);
        let again = LoopLimits::build(limits.values(), &unknown, 1e-3).unwrap();
        assert_eq!((again.values(), again.implausible_n), (limits.values(), 5.0 * 3.3), "built again from its own values");
        assert!(limits.lowered(&LoopLimitSettings { max_force_n: 0.6, ..*limits.values() }).is_err());
        let weaker = LoopLimitSettings { max_force_n: 0.3, ..LoopLimitSettings::DESKTOP };
        assert_eq!(LoopLimits::build(&weaker, &unknown, 1e-3).unwrap().values(), &weaker);
    }

    #[test]
    fn a_lowered_force_makes_no_tissue_implausible() {
        let lower = LoopLimitSettings { max_force_n: 0.1, ..LoopLimitSettings::DESKTOP };
        assert_eq!(limits().lowered(&lower).unwrap().implausible_n, 5.0 * 3.3);
        assert_eq!(LoopLimits::build(&lower, &device(), 1e-3).unwrap().implausible_n, 5.0 * 3.3, "opened with it");
    }

    #[test]
    fn limits_go_down_and_never_up() {
        for pick in SCALARS {
            let (mut lower, mut higher) = (LoopLimitSettings::DESKTOP, LoopLimitSettings::DESKTOP);
            *pick(&mut lower) *= 0.5;
            *pick(&mut higher) *= 1.001;
            assert!(limits().lowered(&higher).is_err(), "{higher:?}");
            let strict = limits().lowered(&lower).unwrap();
            assert_eq!(strict.values(), &lower);
            assert!(strict.lowered(&LoopLimitSettings::DESKTOP).is_err(), "and not back up");
        }
        for pick in COUNTS {
            let mut higher = LoopLimitSettings::DESKTOP;
            *pick(&mut higher) += 1;
            assert!(limits().lowered(&higher).is_err(), "{higher:?}");
        }
    }
}
