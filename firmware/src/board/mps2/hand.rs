//! A scripted hand in place of encoders, for a host on the UART: the board then has sensors of its
//! own, as real ones have.

use core::sync::atomic::{AtomicU32, Ordering};

use palpate::haptic::device::Sensed;
use palpate_controller::script::{self, LEAD_TICKS, REPEAT_TICKS};

/// From outside the tissue, long enough to be armed there, through its presses and out again.
const ROUND_TICKS: u32 = LEAD_TICKS + REPEAT_TICKS;

/// Readings so far; 0 without a hand.
static READINGS: AtomicU32 = AtomicU32::new(0);

/// From now on it presses.
pub fn begin() {
    READINGS.store(1, Ordering::Relaxed);
}

/// Whether there is a hand.
pub fn presses() -> bool {
    READINGS.load(Ordering::Relaxed) > 0
}

/// The next reading.
pub fn sense() -> Option<Sensed> {
    let reading = READINGS.load(Ordering::Relaxed);
    if reading == 0 {
        return None;
    }
    READINGS.store(reading.wrapping_add(1).max(1), Ordering::Relaxed);
    Some(Sensed { sequence: reading, ..script::sensed(reading % ROUND_TICKS, LEAD_TICKS) })
}
