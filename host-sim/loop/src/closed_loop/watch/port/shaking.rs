//! I15: the force does not shake the hand unless the hand's own motion explains it.
//!
//! A force shakes if its part above 15 Hz is stronger than 50 mN RMS in half of the tenths of a
//! second within 2 s: tissue rings after a tap or a stop, but not for a second.
//!
//! The motion of a hand explains a tenth if the tissue would change its force as fast under that
//! motion. A force `F` at depth `d` changes by no more than its slope, some `6 F / d`, times the
//! speed, so the rates of change are compared: a slow motion over many element edges explains a
//! fast force. Only motion below 15 Hz counts as the hand's. Taps, kneading and slides are
//! explained by it, and a limit cycle explains nothing by its own vibration, whether the hand rests
//! or moves.
//!
//! A hand that vibrates by itself, such as one whose grip changes suddenly, explains its vibration.
//! It differs from one that is shaken by where the energy comes from: a passive hand and handle
//! keep vibrating only if the force does work on them above 15 Hz. If instead they do work on the
//! device there, summed over the tenths that shake, the vibration is theirs. A cycle is missed if
//! meanwhile the hand does more work along another axis or at another frequency.

use palpate::Vector3;

use super::Truth;
use crate::closed_loop::butterworth::Butterworth;
use crate::closed_loop::watch::Broken;
use palpate_tissue::scene::TICK_S;

/// Frequency that divides motion from vibration [Hz].
const DIVIDES_HZ: f64 = 15.0;
/// Force above that frequency that counts as shaking, RMS [N].
const SHAKES_N: f64 = 0.05;
/// Ticks of a part of the window, and number of parts: 2 s.
const PART_TICKS: u32 = 100;
const PARTS: usize = 20;
/// Parts that must shake for the window to do so.
const LASTING_PARTS: usize = PARTS / 2;
/// Slope of a tissue's force relative to force over depth (1): 1.5 for a ball on an elastic solid,
/// twice that for tissue that stiffens, and twice again because a moved tissue answers more stiffly
/// than one at rest. Slides of random hands reach three quarters of this, the limit cycle of an
/// encoder's counts thirty times as much.
const SLOPE: f64 = 6.0;
/// Mean work above 15 Hz of a hand on the device, per part that shakes, that makes it the source of
/// the vibration [J]: far below the 30 uJ and more of a changing grip, far above what filters leave
/// of a motion.
const SOURCE_J: f64 = 1e-6;
/// Depth below which force over depth is not taken for a stiffness [m].
const LEAST_DEPTH_M: f64 = 1e-3;

/// Sums of squares over a part of the window.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    force: f64,
    rate: f64,
    explained: f64,
    /// Work on the hand above 15 Hz [J].
    work_j: f64,
}

/// Filters the true force and motion, and compares them.
#[derive(Clone, Debug)]
pub struct ShakingWatch {
    force: Butterworth,
    velocity: Butterworth,
    vibration: Butterworth,
    last: Option<(Vector3<f64>, Vector3<f64>)>,
    parts: [Part; PARTS],
    now: Part,
    ticks: u32,
}

impl Default for ShakingWatch {
    fn default() -> Self {
        Self {
            force: Butterworth::high(DIVIDES_HZ),
            velocity: Butterworth::low(DIVIDES_HZ),
            vibration: Butterworth::high(DIVIDES_HZ),
            last: None,
            parts: [Part::default(); PARTS],
            now: Part::default(),
            ticks: 0,
        }
    }
}

impl ShakingWatch {
    /// Checks a tick that ends at this depth [m].
    pub(super) fn check(&mut self, truth: &Truth, depth_m: f64) -> Result<(), Broken> {
        let shaking_n = self.force.next(truth.mean_n);
        let (last_m, last_n) = self.last.replace((truth.at_m, shaking_n)).unwrap_or((truth.at_m, shaking_n));
        let moved_m = truth.at_m - last_m;
        let slow_m_per_s = self.velocity.next(moved_m / TICK_S);
        let slope_n_per_m = SLOPE * truth.mean_n.norm() / depth_m.max(LEAST_DEPTH_M);
        self.now.force += shaking_n.norm_squared();
        self.now.rate += ((shaking_n - last_n) / TICK_S).norm_squared();
        self.now.explained += slope_n_per_m * slope_n_per_m * slow_m_per_s.norm_squared();
        self.now.work_j += shaking_n.dot(&self.vibration.next(moved_m));
        self.ticks += 1;
        if !self.ticks.is_multiple_of(PART_TICKS) {
            return Ok(());
        }
        self.parts.rotate_left(1);
        self.parts[PARTS - 1] = std::mem::take(&mut self.now);
        let shaking = || self.parts.iter().filter(|part| part.shakes());
        let (count, work_j) = (shaking().count(), shaking().map(|part| part.work_j).sum::<f64>());
        if count < LASTING_PARTS || work_j < -SOURCE_J * count as f64 {
            Ok(())
        } else {
            Err(Broken { id: "I15", what: "shaking without a motion" })
        }
    }
}

impl Part {
    /// Whether the force shook the hand, and its motion does not explain it.
    fn shakes(&self) -> bool {
        // written so that NaN shakes
        !(self.force <= SHAKES_N * SHAKES_N * f64::from(PART_TICKS) || self.rate <= self.explained)
    }
}
