//! Fades out a force that cannot be that of a hand at rest: a strong force without a single count.
//!
//! An encoder that dies while the hand rests cannot be distinguished at once from a hand that
//! rests, and the force would stay as it was for ever. But nobody holds a strong force without
//! moving: the force of a holding hand fluctuates by some 3 % and, without a display to follow,
//! drifts by 5 to 10 % within seconds, and muscles tremble at 8 to 12 Hz. Only the device's
//! friction, 1 to 4 % of its maximum force on desktop devices, can hide this. So, above half of the
//! maximum force and above 1 N, the force fades to zero, as fast as a force at its limit is
//! relieved, after five seconds without a single count on any axis. Weaker forces stay, because
//! friction may hide their fluctuation. If a saturated contact has been relieved, the threshold is
//! half of the relieved maximum: otherwise the relief itself would bring a strong force below it.
//!
//! A new count ends the fading, and the force stays at its reduced gain, as after saturation. It
//! returns with the next contact, after the probe has moved outside the tissue.
//!
//! * in: displacement of the tick [m], force sent last and maximum force after relief [N], whether
//!   the patch is touched
//! * out: force [N] times a gain (0 .. 1)
//! * cost: 20 instructions of a Cortex-M4F, estimated
//! * failures: none; the mode becomes `Degraded`, and the flag `GAIN` is set

use nalgebra::Vector3;

use super::cycle::ArmingSettings;
use super::seen::{Monitor, Seen, Shaper};
use crate::fault::{ClampFlags, Fault};

/// Absolute threshold [N]: no hand holds a larger force without moving.
/// Source: derived from the fluctuation of 3 % above; of 1 N it is the friction of the Touch, 30
/// mN.
const STRONG_N: f32 = 1.0;
/// Threshold relative to the maximum force (1), for devices with more friction; the larger
/// threshold applies.
/// Source: derived; the force of a hand drifts by 5 to 10 %: of half the maximum that is 2.5 to 5
/// %, above a friction of 1 to 4 % of the maximum but for the largest
/// (`a_strong_device_may_hide_more_in_its_friction`).
const STRONG_SHARE: f32 = 0.5;
/// Time without a count after which the force fades [s].
/// Source: derived; without a display, the force of a finger keeps its level for 0.5 to 1.5 s and
/// then decays (Vaillancourt and Russell, Experimental Brain Research 145, 2002): three times that.
const STILL_S: f32 = 5.0;

/// Watches for missing counts in a contact.
#[derive(Clone, Copy, Debug)]
pub struct Stillness {
    /// Ticks after which the force fades.
    most_ticks: f32,
    fade_per_tick: f32,
    /// Ticks without a count under a strong force.
    still_ticks: f32,
    gain: f32,
}

impl Stillness {
    /// Creates the watch for a loop with this tick [s].
    #[must_use]
    pub fn new(arming: &ArmingSettings, tick_s: f32) -> Self {
        Self { most_ticks: STILL_S / tick_s, fade_per_tick: arming.relief_per_tick, still_ticks: 0.0, gain: 1.0 }
    }

    /// Gain on the force (1).
    #[must_use]
    pub fn gain(&self) -> f32 {
        self.gain
    }
}

impl Monitor for Stillness {
    fn judge(&mut self, seen: &Seen) -> Result<(), Fault> {
        if seen.displacement_m != Vector3::zeros() {
            self.still_ticks = 0.0;
            if !seen.touched {
                self.gain = 1.0;
            }
            return Ok(());
        }
        // a force that has begun to fade continues to fade below the threshold
        let strong_n = STRONG_SHARE * seen.relieved_n;
        let strong_n = if strong_n > STRONG_N { strong_n } else { STRONG_N };
        if seen.sent_n.dot(&seen.sent_n) <= strong_n * strong_n && self.gain == 1.0 {
            self.still_ticks = 0.0;
        } else if self.still_ticks < self.most_ticks {
            self.still_ticks += 1.0;
        } else {
            let gain = self.gain - self.fade_per_tick;
            self.gain = if gain > 0.0 { gain } else { 0.0 };
        }
        Ok(())
    }

    fn reset(&mut self) {
        (self.still_ticks, self.gain) = (0.0, 1.0);
    }
}

impl Shaper for Stillness {
    fn shape(&mut self, force_n: Vector3<f32>, _: &Seen, flags: &mut ClampFlags) -> Vector3<f32> {
        if self.gain == 1.0 {
            return force_n;
        }
        flags.set(ClampFlags::GAIN);
        force_n * self.gain
    }

    fn reset(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT: Vector3<f32> = Vector3::new(0.0, 55e-6, 0.0);

    fn rest(still: &mut Stillness, displacement_m: Vector3<f32>, sent_n: Vector3<f32>, relieved_n: f32, touched: bool) {
        let limits = crate::haptic::limits::tests::limits();
        still.judge(&Seen { displacement_m, sent_n, relieved_n, touched, ..Seen::none(&limits) }).unwrap();
    }

    fn hold(still: &mut Stillness, ticks: u16, push_n: f32, every: u16, touched: bool) {
        for n in 1..=ticks {
            let displacement_m = if every > 0 && n.is_multiple_of(every) { COUNT } else { Vector3::zeros() };
            let applied_n = Vector3::new(0.0, 0.0, push_n * still.gain());
            rest(still, displacement_m, applied_n, 2.0, touched);
        }
    }

    #[test]
    fn a_strong_force_without_a_count_is_gone_after_six_seconds() {
        for push_n in [1.01, 3.0, 20.0] {
            let mut still = Stillness::new(&ArmingSettings::DEFAULT, 1e-3);
            hold(&mut still, 5_000, push_n, 0, true);
            assert_eq!(still.gain(), 1.0, "{push_n} N");
            hold(&mut still, 500, push_n, 0, true);
            assert!((still.gain() - 0.5).abs() < 1e-3, "{push_n} N: {}", still.gain());
            let (limits, mut told) = (crate::haptic::limits::tests::limits(), ClampFlags::DEFAULT);
            let left_n = still.shape(Vector3::z() * push_n, &Seen::none(&limits), &mut told);
            assert!((left_n.z / push_n - 0.5).abs() < 1e-3 && told.contains(ClampFlags::GAIN), "{push_n} N: {left_n}");
            hold(&mut still, 501, push_n, 0, true);
            assert_eq!(still.gain(), 0.0, "{push_n} N");
        }
    }

    #[test]
    fn a_weak_force_and_one_count_in_five_seconds_stay() {
        for (push_n, every) in [(0.99, 0), (3.0, 4_999), (3.0, 10)] {
            let mut still = Stillness::new(&ArmingSettings::DEFAULT, 1e-3);
            hold(&mut still, 60_000, push_n, every, true);
            assert_eq!(still.gain(), 1.0, "{push_n} N, every {every}");
        }
        let mut weak = Stillness::new(&ArmingSettings::DEFAULT, 1e-3);
        (0..7_000).for_each(|_| rest(&mut weak, Vector3::zeros(), Vector3::z() * 0.99, 1.0, true));
        assert_eq!(weak.gain(), 1.0, "a force below 1 N on a weak device");
    }

    #[test]
    fn a_faded_force_comes_back_only_after_motion_outside() {
        let mut still = Stillness::new(&ArmingSettings::DEFAULT, 1e-3);
        hold(&mut still, 5_300, 3.0, 0, true);
        let faded = still.gain();
        assert!(faded < 0.8);
        hold(&mut still, 1, 3.0, 1, true);
        hold(&mut still, 3_000, 3.0, 100, true);
        assert_eq!(still.gain(), faded, "a count ends the fading and brings nothing back");
        hold(&mut still, 3_000, 0.0, 0, false);
        assert_eq!(still.gain(), faded, "out of contact without a motion: the patch moved, not the probe");
        hold(&mut still, 1, 0.0, 1, false);
        assert_eq!(still.gain(), 1.0);
    }

    #[test]
    fn a_strong_device_may_hide_more_in_its_friction() {
        for (push_n, gain) in [(3.9, 1.0), (4.1, 0.0)] {
            let mut still = Stillness::new(&ArmingSettings::DEFAULT, 1e-3);
            for _ in 0..7_000 {
                let push_n = Vector3::new(0.0, 0.0, push_n);
                rest(&mut still, Vector3::zeros(), push_n, 8.0, true);
            }
            assert_eq!(still.gain(), gain, "{push_n} N of 8 N");
        }
    }
}
