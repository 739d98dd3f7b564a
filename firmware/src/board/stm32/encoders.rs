//! Three encoders on TIM2, TIM3 and TIM4, read by the tick timer's interrupt.
//!
//! A counter has no time stamp, so every reading counts as new: [`palpate::Fault::PoseStale`]
//! cannot occur here, and a dead encoder looks like a hand at rest. The only check is that each
//! counter still runs in encoder mode.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_stm32::gpio::Pull;
use embassy_stm32::pac::timer::{
    TimGp16,
    vals::{FilterValue, Sms},
};
use embassy_stm32::timer::qei::{Config, Qei};
use embassy_stm32::timer::{Ch1, Ch2, GeneralInstance4Channel, TimerPin};
use embassy_stm32::{Peri, pac};
use palpate::haptic::device::SensorStatus;
use palpate_controller::probe_in::{EncoderCounts, JointReading, Reading, extended};

// SAFETY: the three timers of the encoders. TIM2 counts 32 bits, of which the lower half is used;
// the registers used here are the same in both kinds of timer.
const COUNTERS: [TimGp16; 3] = unsafe {
    [TimGp16::from_ptr(pac::TIM2.as_ptr()), TimGp16::from_ptr(pac::TIM3.as_ptr()), TimGp16::from_ptr(pac::TIM4.as_ptr())]
};
/// Eight samples at an eighth of the timer's clock (0.3 us at 240 MHz, 0.7 us at 90 MHz) must agree
/// before an edge counts: shorter pulses are noise, and a hand at 1 m/s causes 0.1 edges per us.
const FILTER: FilterValue = FilterValue::FDTS_DIV8_N8;

/// Counters at the last edge of the tick timer.
static LATCHED: [AtomicU32; 3] = [const { AtomicU32::new(0) }; 3];
/// Counts of the encoders, extended beyond the 16 bits of the hardware counters.
static COUNTS: [AtomicU32; 3] = [const { AtomicU32::new(0) }; 3];
static READINGS: AtomicU32 = AtomicU32::new(0);

/// Starts one encoder's counter. The pull-ups keep open-collector outputs and unplugged inputs from
/// floating; a push-pull output overrides them.
pub fn start<T: GeneralInstance4Channel>(
    timer: Peri<'static, T>,
    a: Peri<'static, impl TimerPin<T, Ch1>>,
    b: Peri<'static, impl TimerPin<T, Ch2>>,
) {
    let mut config = Config::default();
    (config.ch1_pull, config.ch2_pull) = (Pull::Up, Pull::Up);
    core::mem::forget(Qei::new(timer, a, b, config));
}

/// Filters the inputs of the three counters, which have been started.
pub fn filter() {
    for counter in COUNTERS {
        counter.ccmr_input(0).modify(|w| (0..2).for_each(|channel| w.set_icf(channel, FILTER)));
    }
}

/// Latches the counters; called from the tick timer's interrupt, so that the age of a reading is
/// the same in every tick, regardless of the traffic on the link.
pub fn latch() {
    for (kept, counter) in LATCHED.iter().zip(COUNTERS) {
        kept.store(counter.cnt().read().cnt().into(), Ordering::Relaxed);
    }
}

/// Counts of the three encoders, latched at the edge of the tick timer; the controller converts
/// them to a tip position.
pub fn sense() -> Option<Reading> {
    let [x, y, z] = &COUNTS;
    let [a, b, c] = &LATCHED;
    let counts = [(x, a), (y, b), (z, c)].map(|(kept, latched)| {
        let last = EncoderCounts(kept.load(Ordering::Relaxed).cast_signed());
        let next = extended(last, latched.load(Ordering::Relaxed) as u16);
        kept.store(next.0.cast_unsigned(), Ordering::Relaxed);
        next
    });
    let good = COUNTERS.iter().all(|timer| timer.cr1().read().cen() && timer.smcr().read().sms() == Sms::ENCODER_MODE_3);
    let status = if good { SensorStatus::Good } else { SensorStatus::Failed };
    let sequence = READINGS.load(Ordering::Relaxed).wrapping_add(1);
    READINGS.store(sequence, Ordering::Relaxed);
    Some(Reading::Joints(JointReading { counts, sequence, status }))
}
