//! The device as the haptic cycle sees it. Before a tick the board stores a reading here; after it,
//! the board writes the output from here to its pins.

use palpate::Vector3;
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};

use crate::device::Device;
use crate::force_out::{ActuatorCommand, DacCode, Outputs};
use crate::probe_in::{EncoderCounts, Reading};

/// The device with its latest reading and its latest command.
#[derive(Clone, Copy, Debug)]
pub struct Port {
    limits: DeviceSpec,
    device: Device,
    sensed: Sensed,
    drive: ActuatorCommand,
    operator_switch: bool,
    /// Whether the board has a profile.
    known: bool,
}

impl Port {
    /// A desktop stylus of 3.3 N with a workspace of 0.2 x 0.2 x 0.16 m around its centre and a
    /// delay of one tick. Its enable line is off.
    pub const DESKTOP: Self = Self {
        limits: DeviceSpec {
            max_force_n: 3.3,
            workspace_low_m: Vector3::new(-0.1, -0.1, -0.08),
            workspace_high_m: Vector3::new(0.1, 0.1, 0.08),
            count_m: EncoderCounts::LENGTH_M,
            delay_ticks: 1,
            lag_s: 0.0,
            mass_kg: 0.045,
            stiffness_ceiling_n_per_m: 1e5,
            commissioned: true,
        },
        device: Device::AXES,
        sensed: Sensed { position_m: Vector3::new(0.0, 0.0, 0.0), sequence: 0, status: SensorStatus::Failed },
        drive: ActuatorCommand::Off,
        operator_switch: false,
        known: true,
    };

    /// The desktop stylus with the limits of a profile.
    #[must_use]
    pub fn with_limits(limits: DeviceSpec) -> Self {
        Self { limits, ..Self::DESKTOP }
    }

    /// Sets mechanism, encoders and amplifiers.
    #[must_use]
    pub fn with_device(self, device: Device) -> Self {
        Self { device, ..self }
    }

    /// Forgets the home pose: on a board without a profile neither the encoders' unit nor their
    /// origin is known.
    #[must_use]
    pub fn without_home(self) -> Self {
        Self { device: self.device.without_home(), known: false, ..self }
    }

    /// Sets whether an operator's switch is fitted.
    #[must_use]
    pub fn with_operator_switch(self, operator_switch: bool) -> Self {
        Self { operator_switch, ..self }
    }

    /// Whether the board has a profile.
    pub(crate) fn known(&self) -> bool {
        self.known
    }

    /// Whether the device has a hand switch or a pedal that must be pressed for any force.
    #[must_use]
    pub fn operator_switch(&self) -> bool {
        self.operator_switch
    }

    /// Converts a reading to a tip position and stores it for the next tick.
    pub fn put(&mut self, reading: &Reading) {
        self.sensed = self.device.sensed(reading);
    }

    /// Axes or joints of the device: which there are, metres at the tip per count by the profile,
    /// and share of the converter's range per newton at the tip.
    #[must_use]
    pub fn joints(&self) -> ([bool; 3], [f32; 3], [f32; 3]) {
        self.device.joints()
    }

    /// Mechanism, encoders and amplifiers.
    pub(crate) fn device(&mut self) -> &mut Device {
        &mut self.device
    }

    /// Whether the device's home pose is known.
    #[must_use]
    pub fn homed(&self) -> bool {
        self.device.homed()
    }

    /// Records the present joint positions as the home pose. Returns false if `reading` has no
    /// valid encoder counts.
    pub fn show_home(&mut self, reading: &Reading) -> bool {
        self.device.show_home(reading)
    }

    /// State that the board's outputs should have.
    #[must_use]
    pub fn outputs(&self) -> Outputs {
        self.device.outputs(self.drive)
    }

    /// Command to the actuators.
    #[must_use]
    pub fn drive(&self) -> ActuatorCommand {
        self.drive
    }
}

const _: () = assert!(Port::DESKTOP.limits.max_force_n <= DacCode::FULL_SCALE_N, "the converters must reach the longest force");

impl HapticDevice for Port {
    fn limits(&self) -> DeviceSpec {
        self.limits
    }

    fn sense(&mut self) -> Sensed {
        self.sensed
    }

    fn actuate(&mut self, force_n: Vector3<f32>) {
        self.drive = ActuatorCommand::Force(force_n);
    }

    fn release(&mut self) {
        self.drive = ActuatorCommand::Off;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_has_the_limits_of_its_profile() {
        let limits = DeviceSpec { max_force_n: 1.2, ..Port::DESKTOP.limits() };
        assert_eq!(Port::with_limits(limits).limits(), limits);
        assert_eq!(Port::with_limits(limits).with_operator_switch(true).limits(), limits);
    }

    #[test]
    fn a_home_pose_is_known_until_it_is_forgotten_or_another_device_comes() {
        assert!(Port::DESKTOP.homed());
        assert!(!Port::DESKTOP.without_home().homed());
        assert!(!Port::DESKTOP.with_device(Device::AXES.without_home()).homed());
    }
}
