//! A hand that the emulator's host moves, in place of encoders: the board then has sensors of its
//! own, as real ones have.

use core::sync::atomic::{AtomicU32, Ordering};

use palpate::Vector3;
use palpate::haptic::device::{Sensed, SensorStatus};

/// Readings so far; 0 without a hand.
static READINGS: AtomicU32 = AtomicU32::new(0);
/// Bits of the tip's position [m].
static POSITION_M: [AtomicU32; 3] = [const { AtomicU32::new(0) }; 3];

/// Whether there is a hand.
pub fn is_there() -> bool {
    READINGS.load(Ordering::Relaxed) > 0
}

/// Moves it: three numbers [m], little-endian.
pub fn to(position_m: &[u8; 12]) {
    for (bits, bytes) in POSITION_M.iter().zip(position_m.as_chunks().0) {
        bits.store(u32::from_le_bytes(*bytes), Ordering::Relaxed);
    }
    READINGS.store(READINGS.load(Ordering::Relaxed).wrapping_add(1).max(1), Ordering::Relaxed);
}

/// Its newest reading.
pub fn sense() -> Option<Sensed> {
    let [x, y, z] = POSITION_M.each_ref().map(|bits| f32::from_bits(bits.load(Ordering::Relaxed)));
    let sequence = READINGS.load(Ordering::Relaxed);
    (sequence > 0).then_some(Sensed { position_m: Vector3::new(x, y, z), sequence, status: SensorStatus::Good })
}
