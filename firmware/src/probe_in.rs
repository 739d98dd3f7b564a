//! Encoder counts in, probe pose out.

use fixed::types::I2F30;
use palpate::{ProbePose, Vector3};

/// Position of one axis as its encoder counts it, from the device's centre; positive along the device frame's axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderCounts(pub i32);

impl EncoderCounts {
    /// Length of one count [m]: 10 um. At 55 um one count on 100 kPa tissue is 70 mN, which the hand feels as a buzz.
    ///
    /// `I2F30` holds +-2 m in steps of 0.93 nm, so the rounded scale is off by less than 5e-5 relative: 5 um at 100 mm.
    pub const M_PER_COUNT: I2F30 = I2F30::lit("0.00001");

    /// Position on this axis [m]; saturates at +-2 m. An integer multiple of the scale: exact until the one rounding to `f32`.
    #[must_use]
    pub fn position_m(self) -> f32 {
        Self::M_PER_COUNT.saturating_mul_int(self.0).to_num()
    }
}

/// The pose of a tip on three orthogonal axes.
#[must_use]
pub fn pose(counts: [EncoderCounts; 3]) -> ProbePose {
    ProbePose { tip_m: Vector3::from(counts.map(EncoderCounts::position_m)) }
}

/// Ticks after which the script begins anew.
const SCRIPT_TICKS: u32 = 2_000;
/// Where the tip starts and returns to: 0.6 mm above the surface.
const CLEAR: i32 = 60;
/// Depth of every press: 4 mm.
const DEEP: i32 = 400;

/// Scripted hand, in place of encoders until the link is there: a tap of 0.23 m/s to 4 mm, a hold, a slow way out, then a slow press that slides
/// 3 mm to and fro in x.
#[must_use]
pub fn scripted(tick: u32) -> [EncoderCounts; 3] {
    let phase = (tick % SCRIPT_TICKS) as i32;
    let (depth, x) = match phase {
        0..20 => (ramp(phase, 20), 0),
        20..300 => (CLEAR + DEEP, 0),
        300..800 => (ramp(800 - phase, 500), 0),
        _ => (triangle(phase - 800, 1_200, CLEAR + DEEP), triangle(phase - 800, 600, 300) - triangle(phase - 800, 1_200, 300)),
    };
    [EncoderCounts(x), EncoderCounts(0), EncoderCounts(CLEAR - depth)]
}

/// Share `phase / length` of the whole way down.
fn ramp(phase: i32, length: i32) -> i32 {
    phase * (CLEAR + DEEP) / length
}

/// Triangle wave of an even `period`, from 0 to `height` and back.
fn triangle(phase: i32, period: i32, height: i32) -> i32 {
    let half = period / 2;
    let phase = phase % period;
    let rising = if phase < half { phase } else { period - phase };
    rising * height / half
}

#[cfg(test)]
mod tests {
    use super::{EncoderCounts, scripted};

    #[test]
    fn one_count_is_ten_micrometres() {
        let relative = (EncoderCounts(1_000).position_m() - 0.01) / 0.01;
        assert!(relative.abs() < 5e-5, "{relative}"); // half a step of the scale: 0.47 nm / 10 um
    }

    #[test]
    fn counts_far_outside_the_workspace_saturate() {
        assert!((EncoderCounts(i32::MAX).position_m() - 2.0).abs() < 1e-6);
        assert!((EncoderCounts(i32::MIN).position_m() + 2.0).abs() < 1e-6);
    }

    #[test]
    fn the_script_presses_and_lets_go() {
        let heights = (0..super::SCRIPT_TICKS).map(|tick| scripted(tick)[2].0);
        assert_eq!(heights.clone().min(), Some(-super::DEEP));
        assert_eq!(heights.max(), Some(super::CLEAR));
    }

    #[test]
    fn the_script_never_jumps() {
        for tick in 0..2 * super::SCRIPT_TICKS {
            for (a, b) in scripted(tick).iter().zip(scripted(tick + 1)) {
                assert!((a.0 - b.0).abs() <= 23, "tick {tick}"); // 23 counts a tick = 0.23 m/s
            }
        }
    }
}
