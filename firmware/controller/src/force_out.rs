//! Conversion of forces to converter codes.

pub mod bridge;

use palpate::Vector3;

/// Command to the actuators.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActuatorCommand {
    /// No force; the enable line is off.
    Off,
    /// A force on the hand [N], device frame; the enable line is on.
    Force(Vector3<f32>),
}

/// Output of one axis in the unit of its converter: +-32767 is +-[`DacCode::FULL_SCALE_N`], 0 is no
/// force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DacCode(pub i16);

impl DacCode {
    /// The code that makes no force.
    pub const ZERO: Self = Self(0);
    /// Force at code 32767 [N]: above the 12 N of the strongest desktop device, half a millinewton
    /// per code.
    pub const FULL_SCALE_N: f32 = 16.0;
    /// Codes per newton: 32767 / 16, exact in single precision.
    const PER_N: f32 = 2047.9375;

    /// Nearest code; saturates at full scale. Not-a-number gives no force, since nothing sensible
    /// can be rendered. Computed in floating point, since the FPU converts and saturates in one
    /// instruction.
    #[must_use]
    pub fn from_force_n(force_n: f32) -> Self {
        Self::nearest(force_n * Self::PER_N)
    }

    /// Nearest code for a share of the converter's range (1), between -1 and 1; saturates beyond,
    /// and not-a-number is zero.
    #[must_use]
    pub fn from_share(share: f32) -> Self {
        Self::nearest(share * 32_767.0)
    }

    #[inline]
    fn nearest(codes: f32) -> Self {
        let nearest = (codes + 0.5_f32.copysign(codes)) as i32; // truncates toward zero
        Self(nearest.clamp(-0x7FFF, 0x7FFF) as i16)
    }
}

/// State of a board's output pins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outputs {
    /// Whether the amplifiers' enable line is on.
    pub enabled: bool,
    /// Converter code of each axis or joint.
    pub codes: [DacCode; 3],
}

impl Outputs {
    /// Enable line off, no force on any axis.
    pub const OFF: Self = Self { enabled: false, codes: [DacCode::ZERO; 3] };
    /// Codes that report a disagreement between the pins and the values last written; no force is
    /// converted to them.
    pub const UNKNOWN: [DacCode; 3] = [DacCode(i16::MIN); 3];
}

/// Converts a command to the outputs of three orthogonal axes.
#[must_use]
pub fn outputs(drive: ActuatorCommand) -> Outputs {
    match drive {
        ActuatorCommand::Off => Outputs::OFF,
        ActuatorCommand::Force(force_n) => Outputs { enabled: true, codes: <[f32; 3]>::from(force_n).map(DacCode::from_force_n) },
    }
}

#[cfg(test)]
mod tests {
    use super::DacCode;

    #[test]
    fn full_scale_maps_to_the_last_code_on_both_sides() {
        assert_eq!(DacCode::from_force_n(16.0), DacCode(32_767));
        assert_eq!(DacCode::from_force_n(-16.0), DacCode(-32_767));
        assert_eq!(DacCode::from_force_n(1.0), DacCode(2_048)); // 2047.9375 rounds up
    }

    #[test]
    fn forces_beyond_the_converter_saturate() {
        for huge in [16.1, 1e9, f32::MAX, f32::INFINITY] {
            assert_eq!(DacCode::from_force_n(huge), DacCode(32_767));
            assert_eq!(DacCode::from_force_n(-huge), DacCode(-32_767));
        }
    }

    #[test]
    fn what_is_not_a_number_gives_no_force() {
        assert_eq!(DacCode::from_force_n(f32::NAN), DacCode::ZERO);
    }

    #[test]
    fn codes_follow_the_force_to_half_a_code() {
        for step in -16_000..=16_000 {
            let force_n = step as f32 * 1e-3;
            let back_n = f32::from(DacCode::from_force_n(force_n).0) / 2047.9375;
            assert!((back_n - force_n).abs() <= 0.501 / 2047.9375, "{force_n} N came back as {back_n} N");
        }
    }
}
