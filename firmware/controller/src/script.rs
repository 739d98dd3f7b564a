//! A scripted hand in place of encoders, for runs without a host: it waits above the tissue until
//! the force is enabled, then presses.

use palpate::haptic::device::{Sensed, SensorStatus};

use crate::probe_in::{self, EncoderCounts};

/// Ticks above the tissue before the first press: start-up, 100 calm ticks, 500 ticks of ramp-in,
/// and a margin.
pub const LEAD_TICKS: u32 = 700;
/// Ticks after which the presses repeat.
const REPEAT_TICKS: u32 = 2_000;
/// Height above the surface at which the tip starts and to which it returns [counts]: 0.6 mm.
const CLEAR: i32 = 60;
/// Depth of every press [counts]: 4 mm.
const DEEP: i32 = 400;

/// Speed of the tap [counts per tick].
const TAP: i32 = 23;
/// Displacements at the tap's last ticks [counts]: like a hand, it brakes; only the reading of a
/// broken encoder would stop at once.
const BRAKING: [i32; 5] = [432, 445, 454, 459, CLEAR + DEEP];
/// Ticks of the tap before it brakes.
const STEADY: i32 = 18;

/// Duration of a run of the scripted hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Script {
    /// Ticks until the run ends.
    pub ticks: u32,
    /// Ticks above the tissue before the first press.
    pub lead_ticks: u32,
}

/// The tip position in a tick, as a good reading.
#[must_use]
pub fn sensed(tick: u32, lead_ticks: u32) -> Sensed {
    let position_m = probe_in::pose(counts(tick, lead_ticks)).tip_m;
    Sensed { position_m, sequence: tick, status: SensorStatus::Good }
}

/// The encoder counts in a tick: after the wait, a tap of 0.23 m/s to 4 mm, a hold, a slow retreat,
/// then a slow press that slides 3 mm to and fro in x.
#[must_use]
pub fn counts(tick: u32, lead_ticks: u32) -> [EncoderCounts; 3] {
    let Some(pressing) = tick.checked_sub(lead_ticks) else { return [EncoderCounts(0), EncoderCounts(0), EncoderCounts(CLEAR)] };
    let phase = (pressing % REPEAT_TICKS) as i32;
    let (depth, x) = match phase {
        0..=STEADY => (TAP * phase, 0),
        ..300 => (usize::try_from(phase - STEADY - 1).ok().and_then(|n| BRAKING.get(n)).copied().unwrap_or(CLEAR + DEEP), 0),
        300..800 => (ramp(800 - phase, 500), 0),
        _ => (triangle(phase - 800, 1_200, CLEAR + DEEP), triangle(phase - 800, 600, 300) - triangle(phase - 800, 1_200, 300)),
    };
    [EncoderCounts(x), EncoderCounts(0), EncoderCounts(CLEAR - depth)]
}

/// Share `phase / length` of the full displacement [counts].
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
    use super::{CLEAR, DEEP, LEAD_TICKS, REPEAT_TICKS, counts};

    #[test]
    fn it_waits_presses_and_lets_go() {
        assert!((0..=LEAD_TICKS).all(|tick| counts(tick, LEAD_TICKS)[2].0 == CLEAR));
        let heights = (0..REPEAT_TICKS).map(|tick| counts(tick, 0)[2].0);
        assert_eq!(heights.clone().min(), Some(-DEEP));
        assert_eq!(heights.max(), Some(CLEAR));
    }

    #[test]
    fn it_never_jumps() {
        for tick in 0..LEAD_TICKS + 2 * REPEAT_TICKS {
            for (a, b) in counts(tick, LEAD_TICKS).iter().zip(counts(tick + 1, LEAD_TICKS)) {
                assert!((a.0 - b.0).abs() <= 23, "tick {tick}"); // 23 counts per tick = 0.23 m/s
            }
        }
    }
}
