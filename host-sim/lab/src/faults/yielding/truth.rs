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

/// Acceleration of the tip in a tick by everything but the motors [m/s^2], from the velocity at its
/// start [m/s].
pub(super) fn hand_m_per_s2(from_m_per_s: &Vector3<f64>, plant: &Plant, case: &YieldingCase) -> f64 {
    let moved_kg = case.device.mass_kg + case.hand.mass_kg;
    ((plant.velocity_m_per_s() - from_m_per_s) / TICK_S - plant.truth().mean_n / moved_kg).norm()
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
