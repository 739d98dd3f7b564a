//! True energy given to a hand, and true vibration.

use palpate::Vector3;
use palpate_tissue::scene::TICK_S;

use super::case::YieldingCase;
use palpate_loop::closed_loop::plant::Plant;
use palpate_loop::closed_loop::verdict::rms_above;

/// Frequency above which a force is the loop's [Hz]: hands move more slowly.
const SHAKES_HZ: f64 = 15.0;
/// Time after a press in which a swing may die out, and time at the end in which the hand leaves
/// [ticks].
const SETTLING_TICKS: usize = 1000;
const LEAVING_TICKS: usize = 700;
/// Windows in which vibration is measured, the shortest one, and the time between two [ticks].
const WINDOW_TICKS: usize = 2000;
const SHORTEST_TICKS: usize = 500;
const WINDOW_STEP_TICKS: usize = 250;

/// Velocity and force of a plant at the end of a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instant {
    m_per_s: Vector3<f64>,
    acting_n: Vector3<f64>,
}

impl Instant {
    pub fn of(plant: &Plant) -> Self {
        Self { m_per_s: plant.velocity_m_per_s(), acting_n: plant.acting_n() }
    }

    /// Acceleration of the tip in the tick that follows, by everything but the motors [m/s^2].
    pub fn hand_m_per_s2(&self, after: &Self, case: &YieldingCase) -> f64 {
        let moved_kg = case.device.mass_kg + case.hand.mass_kg;
        // the force follows what the amplifier was asked for; its mean over the tick is exact
        let mean_n = match case.device.amplifier_lag_s {
            lag_s if lag_s > 0.0 => {
                let left = (-TICK_S / lag_s).exp();
                let asked_n = (after.acting_n - self.acting_n * left) / (1.0 - left);
                asked_n + (self.acting_n - asked_n) * (lag_s / TICK_S * (1.0 - left))
            }
            _ => after.acting_n,
        };
        ((after.m_per_s - self.m_per_s) / TICK_S - mean_n / moved_kg).norm()
    }
}

/// Largest RMS force above 15 Hz in a window, from one second after a press of
/// this many ticks until the hand leaves [N].
pub(super) fn shake_n(force_n: &[Vector3<f64>], press_ticks: usize) -> f64 {
    let from = press_ticks + SETTLING_TICKS;
    let to = force_n.len().saturating_sub(LEAVING_TICKS);
    if to < from + SHORTEST_TICKS {
        return 0.0;
    }
    let window = WINDOW_TICKS.min(to - from);
    let starts = (from..=to - window).step_by(WINDOW_STEP_TICKS);
    starts.map(|start| rms_above(&force_n[..start + window], SHAKES_HZ, start)).fold(0.0, f64::max)
}
