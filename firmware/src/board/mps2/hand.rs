//! A hand that the emulator's host moves, in place of encoders: the emulated board then has sensors
//! of its own, like a real one.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use palpate::Vector3;
use palpate::haptic::device::{Sensed, SensorStatus};
use palpate_controller::probe_in::{EncoderCounts, JointReading, Reading};

/// Number of readings so far; 0 if there is no hand.
static READINGS: AtomicU32 = AtomicU32::new(0);
/// Bits of the tip's position [m], or counts of the encoders.
static WORDS: [AtomicU32; 3] = [const { AtomicU32::new(0) }; 3];
/// Whether [`WORDS`] are counts.
static COUNTED: AtomicBool = AtomicBool::new(false);

/// Whether there is a hand.
pub fn is_there() -> bool {
    READINGS.load(Ordering::Relaxed) > 0
}

/// Moves the hand to three coordinates of the tip [m], or to three encoder counts, all
/// little-endian.
pub fn to(words: &[u8; 12], counted: bool) {
    for (bits, bytes) in WORDS.iter().zip(words.as_chunks().0) {
        bits.store(u32::from_le_bytes(*bytes), Ordering::Relaxed);
    }
    COUNTED.store(counted, Ordering::Relaxed);
    READINGS.store(READINGS.load(Ordering::Relaxed).wrapping_add(1).max(1), Ordering::Relaxed);
}

/// The newest reading of the hand.
pub fn sense() -> Option<Reading> {
    let sequence = READINGS.load(Ordering::Relaxed);
    if sequence == 0 {
        return None;
    }
    let words = WORDS.each_ref().map(|bits| bits.load(Ordering::Relaxed));
    let status = SensorStatus::Good;
    Some(if COUNTED.load(Ordering::Relaxed) {
        let counts = words.map(|word| EncoderCounts(word.cast_signed()));
        Reading::Joints(JointReading { counts, sequence, status })
    } else {
        Reading::Tip(Sensed { position_m: Vector3::from(words.map(f32::from_bits)), sequence, status })
    })
}
