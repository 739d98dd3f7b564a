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

/// Distance from the tissue at rest beyond which the sensed tip may not be while a force acts [m]
/// ...
const OUTSIDE_M: f64 = 1e-3;
/// ... for more than this many ticks before it returns.
const OUTSIDE_TICKS: u32 = 5;
/// Largest share of the force that may point into the tissue [N].
const INTO_N: f64 = 0.02;
/// Readings that are stored, to find where the tip entered if a force is delayed.
const TRAIL_TICKS: usize = 64;
/// Ticks with the same reading after which the tip counts as at rest.
const REST_TICKS: u32 = 50;
/// Change of the force from tick to tick that counts [N] ...
const CHATTER_N: f32 = 0.02;
/// ... if it alternates this many ticks in a row.
const CHATTER_TICKS: u32 = 10;

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
    /// Longest run of ticks in which the force alternated at rest.
    pub chatter_ticks: u32,
}

/// Checks tick by tick. [`super::Watch::over`] includes it, and it can be used alone where only
/// readings and forces are known.
#[derive(Clone, Debug)]
pub struct ByGeometry {
    shape: Arc<dyn RestShape>,
    /// Outward normals of the surface through which the tip entered, several at an edge; they
    /// change only while the tip is outside, or at a first touch.
    entry: Vec<Vector3<f64>>,
    /// The last readings, the newest at the back.
    trail_m: VecDeque<Vector3<f64>>,
    outside: u32,
    rest: u32,
    turns: u32,
    last_m: Vector3<f32>,
    last_n: Vector3<f32>,
    last_change_n: Vector3<f32>,
    seen: Seen,
}

impl ByGeometry {
    /// Before the first tick, on this shape.
    #[must_use]
    pub fn over(shape: Arc<dyn RestShape>) -> Self {
        let zero = Vector3::zeros();
        let (last_m, last_n, last_change_n, seen) = (zero, zero, zero, Seen::default());
        let trail_m = VecDeque::with_capacity(TRAIL_TICKS);
        Self { shape, entry: Vec::new(), trail_m, outside: 0, rest: 0, turns: 0, last_m, last_n, last_change_n, seen }
    }

    /// The extremes so far.
    #[must_use]
    pub fn seen(&self) -> Seen {
        self.seen
    }

    /// Checks a tick by its reading and the force on the device [N].
    ///
    /// # Errors
    /// The first invariant that it breaks.
    pub fn check(&mut self, reading: &Sensed, force_n: Vector3<f32>) -> Result<(), Broken> {
        let chatter = self.chatters(reading.position_m, force_n);
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
            // I1 and I7 check these
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
            () if chatter => Err(Broken { id: "I14", what: "chatter at rest" }),
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

    /// Whether the force has alternated from tick to tick for too long while the tip rests.
    fn chatters(&mut self, at_m: Vector3<f32>, force_n: Vector3<f32>) -> bool {
        let change_n = force_n - self.last_n;
        self.rest = if at_m == self.last_m { self.rest + 1 } else { 0 };
        let (before, now) = (self.last_change_n.norm(), change_n.norm());
        let turned = change_n.dot(&self.last_change_n) < 0.0 && before > CHATTER_N && now > CHATTER_N;
        self.turns = if turned && self.rest > REST_TICKS { self.turns + 1 } else { 0 };
        (self.last_m, self.last_n, self.last_change_n) = (at_m, force_n, change_n);
        self.seen.chatter_ticks = self.seen.chatter_ticks.max(self.turns);
        self.turns >= CHATTER_TICKS
    }
}
