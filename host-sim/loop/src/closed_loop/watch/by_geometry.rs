//! Invariants from the sensed tip and geometry at rest: I12 force without contact, I13 force into
//! the tissue, I14 chatter at rest.
//!
//! Nothing reported by the loop or the patch is used: only the reading that went in and the force
//! that came out.

use std::collections::VecDeque;
use std::sync::Arc;

use palpate::Vector3;
use palpate::haptic::device::{Sensed, SensorStatus};

use super::Broken;
use super::rest_shape::RestShape;

/// Distance from the tissue at rest beyond which the sensed tip may not be while a force acts [m],
/// except for [`OUTSIDE_TICKS`].
const OUTSIDE_M: f64 = 1e-3;
/// Ticks for which the tip may be further outside than [`OUTSIDE_M`] before it returns.
const OUTSIDE_TICKS: u32 = 5;
/// Largest component of the force that may point into the tissue [N].
const INTO_N: f64 = 0.02;
/// Readings that are stored, to find where the tip entered if a force is delayed.
const TRAIL_TICKS: usize = 64;
/// Ticks with the same reading after which a force that keeps reversing is chatter: the ringing
/// after a stop may reverse thirty times, and is over by then.
const REST_TICKS: u32 = 250;
/// Smallest change of the force between two reversals that counts as a swing of chatter [N].
const CHATTER_N: f32 = 0.02;
/// Number of consecutive reversals of the force that count as chatter.
const CHATTER_TURNS: u32 = 10;
/// Largest number of ticks between two reversals of chatter, which has swings of 2.5 Hz and faster.
const TURN_TICKS: u32 = 200;

/// Extremes over a run, whether or not they break an invariant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Ticks with a force.
    pub ticks_with_force: u64,
    /// Largest distance of the sensed tip from the tissue while a force acted [m].
    pub outside_m: f64,
    /// Longest run of ticks with a force and the tip more than 1 mm outside.
    pub outside_ticks: u32,
    /// Largest force into the tissue [N].
    pub into_n: f64,
    /// Largest number of consecutive reversals of a force that oscillated at rest.
    pub chatter_turns: u32,
}

/// Checks readings and forces against the geometry, tick by tick. [`super::Watch::over`] includes
/// these checks; they can also be used alone, where only readings and forces are known.
#[derive(Clone, Debug)]
pub struct ByGeometry {
    shape: Arc<dyn RestShape>,
    /// Outward normals of the surface through which the tip entered, several at an edge; they
    /// change only while the tip is outside, or at a first touch.
    entry: Vec<Vector3<f64>>,
    /// The last readings, the newest at the back.
    trail_m: VecDeque<Vector3<f64>>,
    outside: u32,
    swing: Swing,
    seen: Seen,
}

impl ByGeometry {
    /// Creates the watch over this shape, before the first tick.
    #[must_use]
    pub fn over(shape: Arc<dyn RestShape>) -> Self {
        let trail_m = VecDeque::with_capacity(TRAIL_TICKS);
        Self { shape, entry: Vec::new(), trail_m, outside: 0, swing: Swing::default(), seen: Seen::default() }
    }

    /// The extremes so far.
    #[must_use]
    pub fn seen(&self) -> Seen {
        self.seen
    }

    /// Checks a tick by its reading and the force on the device [N].
    ///
    /// # Errors
    /// Returns the first invariant that the tick breaks.
    pub fn check(&mut self, reading: &Sensed, force_n: Vector3<f32>) -> Result<(), Broken> {
        let turns = self.swing.turns(reading.position_m, force_n);
        self.seen.chatter_turns = self.seen.chatter_turns.max(turns);
        if self.trail_m.len() == TRAIL_TICKS {
            self.trail_m.pop_front();
        }
        self.trail_m.push_back(reading.position_m.cast());
        if force_n == Vector3::zeros() {
            // a force that comes and goes outside is counted until the tip returns
            if self.outside > 0 && self.shape.outside_m(&reading.position_m.cast()) <= OUTSIDE_M {
                self.outside = 0;
            }
            // a tip that stays inside without a force has not entered again
            if !self.entry.is_empty() && !self.shape.inside(&reading.position_m.cast()) {
                self.entry.clear();
            }
            return Ok(());
        }
        self.seen.ticks_with_force += 1;
        let readable = reading.position_m.iter().all(|c| c.is_finite()) && reading.status == SensorStatus::Good;
        if !readable || !force_n.iter().all(|c| c.is_finite()) {
            // such values are checked by I1 and I7
            return Ok(());
        }
        let tip_m = reading.position_m.cast::<f64>();
        let (outside_m, inside) = self.shape.place(&tip_m);
        self.outside = if outside_m > OUTSIDE_M { self.outside + 1 } else { 0 };
        // one reading outside may be a glitch: two in a row are needed
        let before_m = self.trail_m.iter().rev().nth(1).copied().unwrap_or(tip_m);
        if self.entry.is_empty() || !inside && !self.shape.inside(&before_m) {
            self.entry = self.shape.normals(&if inside { self.came_in_m() } else { tip_m });
        }
        // a ball at an edge presses several faces: a force out of any of them is no force into the
        // tissue
        let into_n = self.entry.iter().map(|normal| -normal.dot(&force_n.cast())).fold(f64::INFINITY, f64::min);
        let into_n = if inside && into_n.is_finite() { into_n } else { 0.0 };
        let seen = &mut self.seen;
        seen.outside_m = seen.outside_m.max(outside_m);
        seen.outside_ticks = seen.outside_ticks.max(self.outside);
        seen.into_n = seen.into_n.max(into_n);
        match () {
            () if self.outside > OUTSIDE_TICKS => Err(Broken { id: "I12", what: "force without contact" }),
            () if into_n > INTO_N => Err(Broken { id: "I13", what: "force into the tissue" }),
            () if turns >= CHATTER_TURNS => Err(Broken { id: "I14", what: "chatter at rest" }),
            () => Ok(()),
        }
    }

    /// Last position of the tip outside for two readings in a row, or else the newest reading [m].
    fn came_in_m(&self) -> Vector3<f64> {
        let mut newest = self.trail_m.iter().rev();
        let mut later = newest.next().copied().unwrap_or_default();
        let end_m = later;
        for at_m in newest {
            if !self.shape.inside(at_m) && !self.shape.inside(&later) {
                return later;
            }
            later = *at_m;
        }
        end_m
    }
}

/// Swings of the force while the tip rests.
#[derive(Clone, Debug, Default)]
struct Swing {
    last_m: Vector3<f32>,
    /// Ticks with the same reading.
    rest: u32,
    /// Force at the last reversal, and the force farthest from it since then [N].
    turn_n: Vector3<f32>,
    far_n: Vector3<f32>,
    /// Ticks since the last reversal.
    since: u32,
    turns: u32,
}

impl Swing {
    /// Number of consecutive reversals up to this tick, whose reading is `at_m` [m] and whose
    /// output is `force_n` [N].
    fn turns(&mut self, at_m: Vector3<f32>, force_n: Vector3<f32>) -> u32 {
        self.rest = if at_m == self.last_m { self.rest + 1 } else { 0 };
        self.last_m = at_m;
        if self.rest <= REST_TICKS {
            (self.turn_n, self.far_n, self.since, self.turns) = (force_n, force_n, 0, 0);
            return 0;
        }
        self.since += 1;
        if self.since > TURN_TICKS {
            self.turns = 0;
        }
        let (swing_n, back_n) = (self.far_n - self.turn_n, force_n - self.far_n);
        if back_n.norm() > CHATTER_N && back_n.dot(&swing_n) < 0.0 {
            (self.turn_n, self.far_n, self.since) = (self.far_n, force_n, 0);
            // the first swing may begin in the middle of an oscillation, and be only half of one
            self.turns += u32::from(swing_n.norm() > CHATTER_N);
        } else if (force_n - self.turn_n).norm() > swing_n.norm() {
            self.far_n = force_n;
        }
        self.turns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of reversals that are counted for a force that swings by `swing_n` with a half period
    /// of this many ticks, while the reading changes every `moves` ticks. The force begins at its
    /// largest value.
    fn turns(swing_n: f32, half_ticks: u32, moves: u32) -> u32 {
        turns_from(0.0, swing_n, half_ticks, moves)
    }

    /// [`turns`] for a force that begins at another phase [rad].
    fn turns_from(first: f32, swing_n: f32, half_ticks: u32, moves: u32) -> u32 {
        let mut swing = Swing::default();
        let step = |n: u32| {
            let at_m = Vector3::new(0.0, 0.0, (n / moves) as f32 * 55e-6);
            let share = (first + std::f32::consts::PI * n as f32 / half_ticks as f32).cos();
            swing.turns(at_m, Vector3::new(0.1, 0.0, 1.0 + 0.5 * swing_n * share))
        };
        (0..3_000).map(step).max().unwrap_or_default()
    }

    #[test]
    fn a_force_that_swings_at_rest_is_chatter_whatever_its_frequency() {
        for half_ticks in [1, 2, 7, 40, 190] {
            assert!(turns(0.045, half_ticks, 10_000) >= CHATTER_TURNS, "half a period of {half_ticks} ticks");
            assert_eq!(turns(0.019, half_ticks, 10_000), 0, "too small: {half_ticks} ticks");
            assert!(turns(0.5, half_ticks, 245) == 0, "the tip moves: {half_ticks} ticks");
        }
        assert!(turns(0.5, 300, 10_000) < CHATTER_TURNS, "slower than any loop's own swing");
    }

    #[test]
    fn a_swing_is_counted_whole_wherever_it_began() {
        for first in [0.0, 0.7, 1.57, 3.0, 4.71] {
            assert!(turns_from(first, 0.03, 8, 10_000) >= CHATTER_TURNS, "{first}");
            assert_eq!(turns_from(first, 0.019, 8, 10_000), 0, "{first}");
        }
    }

    #[test]
    fn a_force_that_fades_or_settles_is_none() {
        let mut swing = Swing::default();
        for n in 0..4_000_u32 {
            let t = n as f32;
            // a creep of half a newton, and a ringing that reverses thirty times and dies out in
            // 0.2 s
            let force_n = 1.0 + 0.5 * (-t / 800.0).exp() + 0.1 * (-t / 60.0).exp() * (t / 2.0).cos();
            assert_eq!(swing.turns(Vector3::zeros(), Vector3::new(0.0, 0.0, force_n)), 0, "tick {n}");
        }
    }
}
