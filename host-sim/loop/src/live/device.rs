//! Device to which the tip is fixed: the pointer itself, or an emulated hand on an emulated device
//! that follows the pointer.

use palpate::Vector3;
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};
use serde::{Deserialize, Serialize};

use crate::closed_loop::device::DeviceProfile;
use crate::closed_loop::hand::{Aim, Hand};
use crate::closed_loop::plant::Plant;
use palpate_tissue::error::Error;

/// Maximum force with the pointer as probe [N]: high, since nobody feels it and the curve should
/// not be cut off.
pub const POINTER_FORCE_N: f32 = 12.0;

/// Device and hand that hold the probe.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Holding {
    /// Name of the device profile; if `None`, the tip is at the pointer.
    pub device: Option<String>,
    /// Hand by its id, H1 .. H6.
    pub hand: String,
    /// Delay from computing a force to its arrival at the amplifier [ticks]; the profile's own if
    /// `None`.
    pub delay_ticks: Option<u8>,
}

impl Default for Holding {
    /// The pointer without a device, and a firm fingertip as the hand once a device is chosen.
    fn default() -> Self {
        Self { device: None, hand: "H2".into(), delay_ticks: None }
    }
}

/// The pointer as a device, or an emulated device in an emulated hand.
#[derive(Clone, Debug)]
pub(super) enum LiveDevice {
    Pointer(Pointer),
    Held(Box<Plant>),
}

/// A tip that is always at its target: it has no mass, and no force moves it.
#[derive(Clone, Debug)]
pub(super) struct Pointer {
    limits: DeviceSpec,
    at_m: Vector3<f64>,
    sequence: u32,
}

impl LiveDevice {
    /// Creates the device at rest at `start_m`, above the site.
    ///
    /// # Errors
    /// Fails if no device or hand has the given name.
    pub(super) fn new(
        holding: &Holding,
        site_m: Vector3<f32>,
        normal: Vector3<f32>,
        start_m: Vector3<f64>,
    ) -> Result<(Self, f32), Error> {
        let Some(device) = &holding.device else {
            let half = Vector3::repeat(0.5);
            let limits = DeviceSpec {
                max_force_n: POINTER_FORCE_N,
                workspace_low_m: site_m - half,
                workspace_high_m: site_m + half,
                count_m: 0.0,
                delay_ticks: holding.delay_ticks.unwrap_or(0),
                lag_s: 0.0,
                mass_kg: 0.045,
                stiffness_ceiling_n_per_m: 1e5,
                commissioned: true,
            };
            return Ok((Self::Pointer(Pointer { limits, at_m: start_m, sequence: 0 }), POINTER_FORCE_N));
        };
        let mut profile = DeviceProfile::load(device)?;
        profile.delay_ticks = holding.delay_ticks.unwrap_or(profile.delay_ticks);
        profile.check(&|key| format!("device {device}: {key}"))?;
        let hand = Hand::named(&holding.hand)
            .ok_or_else(|| Error::Usage(format!("{} is no hand: give one of H1 to H6", holding.hand)))?;
        let plant = Plant::new(&profile, hand, site_m, normal, start_m);
        Ok((Self::Held(Box::new(plant)), profile.force_limit_n as f32))
    }

    pub(super) fn at_m(&self) -> Vector3<f64> {
        match self {
            Self::Pointer(pointer) => pointer.at_m,
            Self::Held(plant) => plant.at_m(),
        }
    }

    /// Runs one tick towards a target.
    pub(super) fn step(&mut self, target_m: Vector3<f64>, velocity_m_per_s: Vector3<f64>, touched: bool) {
        match self {
            Self::Pointer(pointer) => pointer.at_m = target_m,
            Self::Held(plant) => {
                let push_n = Vector3::zeros();
                plant.step(&Aim { at_m: target_m, velocity_m_per_s, push_n, let_go: false, steady: false }, touched);
            }
        }
    }
}

impl HapticDevice for LiveDevice {
    fn limits(&self) -> DeviceSpec {
        match self {
            Self::Pointer(pointer) => pointer.limits,
            Self::Held(plant) => plant.limits(),
        }
    }

    fn sense(&mut self) -> Sensed {
        match self {
            Self::Pointer(pointer) => {
                pointer.sequence = pointer.sequence.wrapping_add(1);
                Sensed { position_m: pointer.at_m.cast(), sequence: pointer.sequence, status: SensorStatus::Good }
            }
            Self::Held(plant) => plant.sense(),
        }
    }

    fn actuate(&mut self, force_n: Vector3<f32>) {
        if let Self::Held(plant) = self {
            plant.actuate(force_n);
        }
    }

    fn release(&mut self) {
        if let Self::Held(plant) = self {
            plant.release();
        }
    }
}
