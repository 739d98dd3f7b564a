//! Sensors and motors of the axes, as a device's profile states them.

use palpate::haptic::commission::Wiring;
use serde::Deserialize;

/// `[wiring]` of a profile: sensors and motors by number from 0, in the order of the axes x, y, z
/// or of the joints.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct WiringTable {
    /// Sensor of each axis.
    pub sensor: [u8; 3],
    /// Metres per unit of each sensor's reading, or 1 on a mechanism, whose encoders have signs and
    /// counts of their own; negative where the reading falls along the axis.
    pub m_per_unit: [f32; 3],
    /// Motor of each axis.
    pub motor: [u8; 3],
    /// 1, or -1 where a positive command drives the axis backwards.
    pub motor_sign: [f32; 3],
}

impl WiringTable {
    /// The wiring.
    #[must_use]
    pub fn wiring(&self) -> Wiring {
        let Self { sensor, m_per_unit, motor, motor_sign } = *self;
        Wiring { sensor, per_unit: m_per_unit, motor, motor_sign }
    }
}

impl From<&Wiring> for WiringTable {
    fn from(wiring: &Wiring) -> Self {
        let Wiring { sensor, per_unit, motor, motor_sign } = *wiring;
        Self { sensor, m_per_unit: per_unit, motor, motor_sign }
    }
}
