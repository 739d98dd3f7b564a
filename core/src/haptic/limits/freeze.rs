//! Detects a reading that stops dead: a stuck encoder, or one stuck axis.
//!
//! A probe that moves at 0.2 m/s for three ticks and then reads the same count again and again was
//! stopped within a tick: 200 m/s^2, or nine newtons on a stylus, which no tissue exerts. A hand
//! slows down first: if the last displacement is so much shorter than the one before it that the
//! next would be slow, the stop is not a dead stop. One fast reading alone is a glitch. An encoder
//! that sticks while the hand rests cannot be distinguished from a resting hand, since with
//! friction both look alike. The force then stays; the first implausible displacement once the
//! encoder recovers is a fault of [`super::pose`].
//!
//! * in: the displacement between two readings [m], the position
//! * out: nothing
//! * cost: 60 instructions of a Cortex-M4F, estimated
//! * failures: [`Fault::SensorFault`]

use nalgebra::Vector3;

use super::LoopLimits;
use crate::fault::Fault;
use crate::haptic::HAND_M_PER_S2;

/// Number of fast readings in a row, in one direction, and of equal readings in a row after them,
/// that are a fault.
/// Source: derived; a glitch makes two fast readings, there and back, and a reading that is bridged
/// repeats up to twice. With two,
/// `an_axis_that_stops_dead_from_speed_is_a_fault_at_the_third_equal_reading` fails.
const IN_A_ROW: u8 = 3;
/// Least such speed in counts per tick (1): a coarse encoder makes a slow hand look fast now and
/// then.
/// Source: derived; two counts per tick are a slow hand, three are fast: up to 1.9 and from 3.1 on
/// `two_counts_per_tick_of_a_coarse_encoder_are_not_fast` fails.
const FAST_COUNTS: f32 = 2.5;
/// Next displacement, extrapolated from the last two, up to which equal readings are plausible, in
/// counts (1): less than one count, plus an extrapolation error of less than three.
/// Source: derived; one and three, less a half, since both bounds are open. Up to 3.0
/// `a_hand_that_brakes_evenly_is_no_stuck_encoder_wherever_its_counts_fall` fails, from 4.0 on
/// `what_stops_dead_from_speed_is_a_fault_and_what_slows_down_is_not`.
const UNSEEN_COUNTS: f32 = 3.5;
/// Number of counts by which the last displacement of a braking hand may read longer than that
/// deceleration allows within one tick (1): one count of motion that is no longer read and one of
/// rounding, less a quarter, so that three counts per tick of a coarse encoder do not pass for
/// braking.
/// Source: derived; one and one, less a quarter. Up to 1.0
/// `a_hand_that_brakes_evenly_is_no_stuck_encoder_wherever_its_counts_fall` fails, from 2.0 on
/// `two_counts_per_tick_of_a_coarse_encoder_are_not_fast`.
const BRAKED_COUNTS: f32 = 1.75;
/// Within this distance of the end of the workspace a hard stop may have stopped the probe [m].
/// Source: derived; profiles state workspaces in whole centimetres, so that the place of an end is
/// known to 2.5 mm, of which this is the whole millimetres
/// (`a_hard_stop_within_two_millimetres_of_the_end_is_no_fault`).
const STOP_M: f32 = 2e-3;

/// Watches the readings of each axis.
#[derive(Clone, Copy, Debug, Default)]
pub struct Freeze {
    /// Number of fast readings in a row of each axis, negative in the negative direction.
    moving: [i8; 3],
    /// Number of equal readings since then.
    equal: [u8; 3],
    /// The two last displacements per tick of each axis that were not zero, the newest first [m].
    last_m: [[f32; 2]; 3],
}

impl Freeze {
    /// Judges a new reading, displaced by `displacement_m` from the last accepted one, which is
    /// `ticks` older.
    ///
    /// # Errors
    /// [`Fault::SensorFault`], if a force acts: without one a stuck reading does no harm.
    pub fn judge(
        &mut self,
        limits: &LoopLimits,
        at_m: &Vector3<f32>,
        displacement_m: &Vector3<f32>,
        ticks: u16,
        force_acts: bool,
    ) -> Result<(), Fault> {
        // a hand brings no faster probe to rest within a tick
        let brakes_m = HAND_M_PER_S2 * limits.tick_s * limits.tick_s;
        let counts_m = FAST_COUNTS * 0.5 * limits.counts_m;
        let fast_m = f32::from(ticks) * if counts_m > brakes_m { counts_m } else { brakes_m };
        // no fast motion now or just before: equal readings then mean nothing
        if displacement_m.dot(displacement_m) < fast_m * fast_m && self.moving == [0; 3] {
            self.equal = [0; 3];
            return Ok(());
        }
        let device = &limits.device;
        let mut frozen = false;
        // a hand that was slowing down would move by less than this by now [m]
        let per_tick = 1.0 / f32::from(ticks);
        let count_m = 0.5 * limits.counts_m;
        let slow_m = fast_m * per_tick - count_m;
        let braked_m = brakes_m + BRAKED_COUNTS * count_m;
        let watched = self.moving.iter_mut().zip(&mut self.equal).zip(&mut self.last_m);
        let read = displacement_m.iter().zip(at_m.iter()).zip(device.workspace_low_m.iter().zip(device.workspace_high_m.iter()));
        for (((moving, equal), last_m), ((&displacement_m, at_m), (low_m, high_m))) in watched.zip(read) {
            if displacement_m == 0.0 {
                // an axis that did not move before may rest
                if *moving != 0 {
                    *equal = equal.saturating_add(1);
                    let stopped = *at_m < low_m + STOP_M || *at_m > high_m - STOP_M;
                    let [newest_m, before_m] = last_m.map(f32::abs);
                    let next_m = newest_m + newest_m - before_m;
                    let unseen = next_m < UNSEEN_COUNTS * count_m && newest_m < braked_m;
                    let slowing = next_m < slow_m || unseen;
                    frozen |= *equal == IN_A_ROW && moving.unsigned_abs() >= IN_A_ROW && !stopped && !slowing;
                }
                continue;
            }
            let sense = if displacement_m.abs() < fast_m {
                0
            } else if displacement_m > 0.0 {
                1
            } else {
                -1
            };
            *last_m = [displacement_m * per_tick, last_m[0]];
            // a reading that was equal in between ended the motion
            let goes_on = *equal == 0 && sense != 0 && sense == moving.signum();
            *moving = if goes_on { moving.saturating_add(sense) } else { sense };
            *equal = 0;
        }
        match frozen && force_acts {
            true => Err(Fault::SensorFault),
            false => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{device, limits};
    use super::super::{DeviceSpec, LoopLimitSettings};
    use super::*;

    /// Ticks until the fault after a motion at `m_per_s` and then equal readings.
    fn stops_from(m_per_s: f32, at_m: f32) -> Option<usize> {
        let mut freeze = Freeze::default();
        let at_m = Vector3::new(0.0, at_m, 0.0);
        let mut judge = |displacement_m: f32| freeze.judge(&limits(), &at_m, &Vector3::new(0.0, displacement_m, 0.0), 1, true);
        for _ in 0..3 {
            judge(1e-3 * m_per_s).unwrap();
        }
        (1..20).find(|_| judge(0.0).is_err())
    }

    #[test]
    fn what_stops_dead_from_speed_is_a_fault_and_what_slows_down_is_not() {
        assert_eq!(stops_from(0.21, 0.0), Some(3));
        assert_eq!(stops_from(-0.21, 0.0), Some(3));
        assert_eq!(stops_from(0.1, 0.0), None);
        assert_eq!(stops_from(0.21, 0.0595), None, "the hard stop");
        let mut freeze = Freeze::default();
        for displacement_m in [0.3e-3, 0.3e-3, 0.3e-3, 0.1e-3, 0.0, 0.0, 0.0, 0.0, 1e-3, -1e-3, 0.0, 0.0, 0.0, 0.0] {
            freeze.judge(&limits(), &Vector3::zeros(), &Vector3::new(0.0, displacement_m, 0.0), 1, true).unwrap();
        }
    }

    #[test]
    fn a_stop_is_seen_after_any_number_of_fast_readings_in_either_direction() {
        for m_per_s in [0.3, -0.3] {
            for fast in 3..400_u16 {
                let mut freeze = Freeze::default();
                let mut judge = |displacement_m: f32| {
                    freeze.judge(&limits(), &Vector3::zeros(), &Vector3::new(0.0, 0.0, displacement_m), 1, true)
                };
                assert!((0..fast).all(|_| judge(1e-3 * m_per_s).is_ok()), "{fast} fast readings at {m_per_s} m/s");
                let stopped = [judge(0.0), judge(0.0), judge(0.0)];
                let right = [Ok(()), Ok(()), Err(Fault::SensorFault)];
                assert_eq!(stopped, right, "{fast} fast readings at {m_per_s} m/s");
            }
        }
    }

    #[test]
    fn a_hand_that_brakes_within_the_last_ticks_is_no_stuck_encoder_and_an_even_motion_that_ends_is() {
        let ends = |ways_m: [f32; 4]| {
            let mut freeze = Freeze::default();
            let mut judge = |displacement_m: f32| {
                freeze.judge(&limits(), &Vector3::zeros(), &Vector3::new(0.0, 0.0, displacement_m), 1, true)
            };
            ways_m.into_iter().chain([0.0; 3]).try_for_each(|displacement_m| judge(-displacement_m))
        };
        assert_eq!(ends([0.55e-3, 0.5e-3, 0.36e-3, 0.21e-3]), Ok(()));
        assert_eq!(ends([0.3e-3, 0.3e-3, 0.3e-3, 0.3e-3]), Err(Fault::SensorFault));
        // the next reading contains the displacement of a missing one
        let mut freeze = Freeze::default();
        let mut judge = |displacement_m: f32, ticks| {
            freeze.judge(&limits(), &Vector3::zeros(), &Vector3::new(0.0, 0.0, displacement_m), ticks, true)
        };
        for (displacement_m, ticks) in [(0.3e-3, 1), (0.3e-3, 1), (0.3e-3, 1), (0.6e-3, 2), (0.3e-3, 1), (0.0, 1), (0.0, 1)] {
            assert_eq!(judge(displacement_m, ticks), Ok(()));
        }
        assert_eq!(judge(0.0, 1), Err(Fault::SensorFault));
        // a reading may be missing before the third equal one
        let mut freeze = Freeze::default();
        let mut last = |displacement_m: f32, ticks| {
            freeze.judge(&limits(), &Vector3::zeros(), &Vector3::new(0.0, 0.0, displacement_m), ticks, true)
        };
        (0..4).for_each(|_| assert_eq!(last(0.3e-3, 1), Ok(())));
        assert_eq!([last(0.0, 1), last(0.0, 1), last(0.0, 2)], [Ok(()), Ok(()), Err(Fault::SensorFault)]);
        // a last displacement shorter by one count still counts as an even motion
        assert_eq!(ends([0.33e-3, 0.33e-3, 0.33e-3, 0.275e-3]), Err(Fault::SensorFault));
    }

    #[test]
    fn a_hand_that_brakes_evenly_is_no_stuck_encoder_wherever_its_counts_fall() {
        for [count_m, braking_m] in [[55e-6, 122e-6], [55e-6, 180e-6], [35e-6, 190e-6], [20e-6, 60e-6], [10e-6, 100e-6]] {
            let device = DeviceSpec { count_m, ..device() };
            let limits = LoopLimits::build(&LoopLimitSettings::DESKTOP, &device, 1e-3).unwrap();
            for start in 0..20 {
                for phase in 0..20 {
                    let mut freeze = Freeze::default();
                    let (mut way_m, mut at_m, mut read_m) = (5.0 * braking_m, 0.05 * phase as f32 * count_m, 0.0);
                    way_m += 0.05 * start as f32 * braking_m;
                    for _ in 0..20 {
                        at_m += way_m;
                        way_m = (way_m - braking_m).max(0.0);
                        let now_m = (at_m / count_m).floor() * count_m;
                        let displacement_m = Vector3::new(0.0, 0.0, now_m - read_m);
                        let judged = freeze.judge(&limits, &Vector3::zeros(), &displacement_m, 1, true);
                        assert_eq!(judged, Ok(()), "{count_m} m, {braking_m} m, start {start}, phase {phase}");
                        read_m = now_m;
                    }
                }
            }
        }
    }

    #[test]
    fn on_a_fine_encoder_a_slow_reading_ends_the_motion_and_a_hand_that_slowed_down_is_not_stuck() {
        let ends = |ways_m: [f32; 4]| {
            let device = DeviceSpec { count_m: 10e-6, ..device() };
            let limits = LoopLimits::build(&LoopLimitSettings::DESKTOP, &device, 1e-3).unwrap();
            let mut freeze = Freeze::default();
            let mut judge =
                |displacement_m: f32| freeze.judge(&limits, &Vector3::zeros(), &Vector3::new(displacement_m, 0.0, 0.0), 1, true);
            ways_m.into_iter().chain([0.0; 3]).try_for_each(&mut judge)
        };
        assert_eq!(ends([0.21e-3, 0.21e-3, 0.21e-3, 0.21e-3]), Err(Fault::SensorFault));
        assert_eq!(ends([0.21e-3, 0.195e-3, 0.195e-3, 0.195e-3]), Ok(()));
        assert_eq!(ends([0.5e-3, 0.45e-3, 0.36e-3, 0.25e-3]), Ok(()));
    }

    #[test]
    fn two_counts_per_tick_of_a_coarse_encoder_are_not_fast() {
        let ends = |counts: [f32; 4]| {
            let device = DeviceSpec { count_m: 0.2e-3, ..device() };
            let limits = LoopLimits::build(&LoopLimitSettings::DESKTOP, &device, 1e-3).unwrap();
            let mut freeze = Freeze::default();
            let mut judge = |counts: f32| {
                let displacement_m = Vector3::new(0.0, 0.0, counts * device.count_m);
                freeze.judge(&limits, &Vector3::zeros(), &displacement_m, 1, true)
            };
            counts.into_iter().chain([0.0; 3]).try_for_each(&mut judge)
        };
        assert_eq!(ends([3.0, 2.0, 3.0, 3.0]), Ok(()));
        assert_eq!(ends([2.0, 3.0, 3.0, 3.0]), Err(Fault::SensorFault));
    }

    #[test]
    fn the_margin_of_the_hard_stop_is_two_millimetres() {
        for side in [1.0, -1.0] {
            assert_eq!(stops_from(0.21, side * 0.0581), None);
            assert_eq!(stops_from(0.21, side * 0.0579), Some(3));
        }
    }

    #[test]
    fn a_reading_that_was_equal_ends_the_motion_before_it() {
        let mut freeze = Freeze::default();
        for displacement_m in [0.3e-3, 0.3e-3, 0.0, 0.3e-3, 0.0, 0.0, 0.0, 0.0] {
            freeze.judge(&limits(), &Vector3::zeros(), &Vector3::new(0.0, displacement_m, 0.0), 1, true).unwrap();
        }
    }
}
