//! Sensor and motor of every axis, with their signs and units.

use crate::fault::BuildError;

/// Assignment of sensors and motors to the axes of the device's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wiring {
    /// Number of the sensor that reads each axis.
    pub sensor: [u8; 3],
    /// Displacement along each axis per unit of its sensor; negative where the sensor counts down.
    pub per_unit: [f32; 3],
    /// Number of the motor that drives each axis.
    pub motor: [u8; 3],
    /// 1, or -1 where a positive command drives the axis backwards.
    pub motor_sign: [f32; 3],
}

impl Wiring {
    /// Sensors and motors in the order of the axes, with the right signs, in metres.
    /// Source: definition.
    pub const STRAIGHT: Self = Self { sensor: [0, 1, 2], per_unit: [1.0; 3], motor: [0, 1, 2], motor_sign: [1.0; 3] };

    /// Positions along the axes for the values of the sensors.
    #[must_use]
    #[inline]
    pub fn read(&self, sensors: [f32; 3]) -> [f32; 3] {
        let [a, b, c] = self.sensor.map(|sensor| nth(sensors, sensor));
        let [per_a, per_b, per_c] = self.per_unit;
        [a * per_a, b * per_b, c * per_c]
    }

    /// Commands to the motors for forces along the axes.
    #[must_use]
    #[inline]
    pub fn drive(&self, along: [f32; 3]) -> [f32; 3] {
        let mut commands = [0.0; 3];
        for (motor, (force, sign)) in self.motor.iter().zip(along.into_iter().zip(self.motor_sign)) {
            if let Some(command) = commands.get_mut(usize::from(*motor)) {
                *command = force * sign;
            }
        }
        commands
    }

    /// Checks that every axis has a sensor and a motor of its own.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the first entry that is wrong.
    #[inline]
    pub fn check(&self) -> Result<(), BuildError> {
        for (name, order) in [("wiring.sensor", self.sensor), ("wiring.motor", self.motor)] {
            let [a, b, c] = order;
            for axis in order {
                BuildError::within(name, f32::from(axis), 0.0, 2.0)?;
            }
            if a == b || b == c || a == c {
                return Err(BuildError::Degenerate { item: name, index: 0 });
            }
        }
        for per_unit in self.per_unit {
            BuildError::within("wiring.per_unit", per_unit.abs(), 1e-9, 1e3)?;
        }
        for sign in self.motor_sign {
            BuildError::within("wiring.motor_sign", sign.abs(), 1.0, 1.0)?;
        }
        Ok(())
    }
}

/// The entry of this number; zero if there is none.
#[inline]
pub(super) fn nth(values: [f32; 3], number: u8) -> f32 {
    values.get(usize::from(number)).copied().unwrap_or(0.0)
}
