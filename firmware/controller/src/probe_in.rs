//! Readings of the sensors, and the probe pose of three orthogonal axes.

use palpate::haptic::device::{Sensed, SensorStatus};
use palpate::{ProbePose, Vector3};

/// Count of one encoder. On three orthogonal axes it is the position from the device's centre,
/// positive along the device frame's axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderCounts(pub i32);

impl EncoderCounts {
    /// Length of one count [m], for device profiles. At 55 um one count on 100 kPa tissue is 70 mN,
    /// which the hand feels as a buzz.
    pub const LENGTH_M: f32 = 1e-5;
    /// Length of one count [`Self::STEP_M`]: 10 um, rounded, which is off by less than 5e-5
    /// relative: 5 um at 100 mm.
    const STEPS: i32 = 10_737;
    /// Step of a position in 32 bits, which then holds +-2 m: 2^-30 m = 0.93 nm.
    const STEP_M: f32 = 1.0 / (1_u32 << 30) as f32;

    /// Position on this axis [m]; saturates at +-2 m. The product with the integer count is exact;
    /// only the conversion to `f32` rounds.
    #[must_use]
    pub fn position_m(self) -> f32 {
        self.0.saturating_mul(Self::STEPS) as f32 * Self::STEP_M
    }
}

/// Reading of a board's sensors in a tick, before the device converts it to a tip position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// Counts of the encoders.
    Joints(JointReading),
    /// A tip position, from a host or a script in place of encoders.
    Tip(Sensed),
}

/// Counts of up to three encoders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JointReading {
    /// One count per joint, in the mechanism's order; zero where there is no joint.
    pub counts: [EncoderCounts; 3],
    /// Number of the reading; it increases by one with each new reading and wraps.
    pub sequence: u32,
    /// Whether the reading can be trusted.
    pub status: SensorStatus,
}

impl From<Sensed> for Reading {
    fn from(sensed: Sensed) -> Self {
        Self::Tip(sensed)
    }
}

/// Unwraps a 16-bit counter relative to `last`: in one tick it changes by far less than half of its
/// range.
#[must_use]
pub fn extended(last: EncoderCounts, counter: u16) -> EncoderCounts {
    let moved = counter.wrapping_sub(last.0 as u16).cast_signed();
    EncoderCounts(last.0.wrapping_add(i32::from(moved)))
}

/// The pose of a tip on three orthogonal axes.
#[must_use]
pub fn pose(counts: [EncoderCounts; 3]) -> ProbePose {
    ProbePose { tip_m: Vector3::from(counts.map(EncoderCounts::position_m)) }
}

#[cfg(test)]
mod tests {
    use super::{EncoderCounts, extended};

    #[test]
    fn one_count_is_ten_micrometres() {
        let relative = (EncoderCounts(1_000).position_m() - 0.01) / 0.01;
        assert!(relative.abs() < 5e-5, "{relative}"); // half a step of the scale: 0.47 nm / 10 um
    }

    #[test]
    fn a_short_counter_goes_on_over_its_turns_both_ways() {
        for step in [1_i32, 300, 32_767, -1, -300, -32_768] {
            let mut counts = EncoderCounts(0);
            for tick in 1..=1_000 {
                counts = extended(counts, (tick * step) as u16);
                assert_eq!(counts, EncoderCounts(tick * step));
            }
        }
    }

    #[test]
    fn counts_far_outside_the_workspace_saturate() {
        assert!((EncoderCounts(i32::MAX).position_m() - 2.0).abs() < 1e-6);
        assert!((EncoderCounts(i32::MIN).position_m() + 2.0).abs() < 1e-6);
    }
}
