//! Compares the encoder's steps with the profile, to detect a unit or a scale that is wrong by a
//! factor of ten or more.
//!
//! A unit that is too large shows within a few counts. Readings are on a grid of counts. So the
//! steps between the readings of a hand at constant speed differ by one or two counts, whatever the
//! speed; while a hand speeds up or turns evenly, the differences between its steps do. If readings
//! are ten times too long, every step, every difference between two steps and every difference of
//! these is zero or at least ten counts. So a step is counted as too long if it is longer than five
//! counts of the profile and differs from the step before by more than five, *and* if that
//! difference itself differs from the one before by nothing or by more than five. The first step
//! that fits ends the check. A hand that speeds up makes some such steps as well: eight beyond
//! those that bring it to its greatest speed are a fault. A hand that trembles while the loop arms
//! is enough for the check.
//!
//! A unit that is too small shows only in motions between two rests, because a driver that filters
//! or interpolates has short steps as well: eight motions from rest to rest, each shorter than a
//! fifth of a count, are a fault. The first step out of a rest that fits ends that check: levers
//! and gears make counts at the probe differ by a factor of two or three, not ten.
//!
//! A device whose profile gives no count (an ideal sensor) is not checked. A unit that is wrong by
//! a factor of 1000 leaves the workspace or is found here. A mirrored axis does not show in the
//! length of a step.
//!
//! * in: displacement between two readings [m]
//! * out: nothing
//! * cost: 45 instructions of a Cortex-M4F until steps fit, 5 after it, estimated
//! * failures: [`Fault::UnitMismatch`]

use nalgebra::Vector3;

use super::between;
use crate::fault::Fault;

/// Number of equal readings in a row that counts as rest.
const REST: u8 = 3;
/// Steps that are this many times longer or shorter than a count do not fit the profile (1).
const FACTOR: f32 = 5.0;
/// Number of steps that are too long (beyond those of a hand that speeds up), or of motions that
/// are too short, that is a fault if none fits.
const MOST: u8 = 8;
/// Largest gain in speed of a hand in one motion [m per tick of 1 ms].
const FASTEST_M: f32 = 1.5e-3;
/// Largest number of steps that is allowed for that gain in speed, however fine the encoder (1).
const PATIENCE: f32 = 200.0;

/// Watches the steps of the readings.
#[derive(Clone, Copy, Debug)]
pub struct UnitWatch {
    /// Square of the shortest and longest step that fits [m^2].
    shortest_m2: f32,
    longest_m2: f32,
    /// Number of steps beyond the longest at which the watch raises its fault.
    most_long: u8,
    /// Equal readings in a row.
    equal: u8,
    /// The last step, and its difference from the step before it [m].
    step_m: Vector3<f32>,
    change_m: Vector3<f32>,
    /// Displacement since the last rest [m].
    gone_m: Vector3<f32>,
    /// Number of steps that were too long; [`u8::MAX`] once a step was not, or if the profile gives
    /// no count.
    long: u8,
    /// Number of motions that were too short; [`u8::MAX`] once a motion was not, or if the profile
    /// gives no count.
    short: u8,
}

/// Value of a counter whose check is over.
const PASSED: u8 = u8::MAX;

impl UnitWatch {
    /// Creates the watch for an encoder with this count [m]; zero if the profile gives none.
    #[must_use]
    pub fn build(count_m: f32) -> Self {
        let (shortest_m, longest_m) = (count_m / FACTOR, count_m * FACTOR);
        let mut watch = Self {
            shortest_m2: shortest_m * shortest_m,
            longest_m2: longest_m * longest_m,
            most_long: MOST + between(FASTEST_M / longest_m, 0.0, PATIENCE) as u8,
            equal: 0,
            step_m: Vector3::zeros(),
            change_m: Vector3::zeros(),
            gone_m: Vector3::zeros(),
            long: 0,
            short: 0,
        };
        watch.reset();
        watch
    }

    /// Judges one reading, displaced by `displacement_m` from the reading before it; `held` is true
    /// if it repeats that reading.
    ///
    /// # Errors
    /// Fails with [`Fault::UnitMismatch`] if enough readings show that the unit or the scale is
    /// wrong.
    pub fn judge(&mut self, displacement_m: &Vector3<f32>, held: bool) -> Result<(), Fault> {
        if held || self.long & self.short == PASSED {
            return Ok(());
        }
        let change_m = displacement_m - self.step_m;
        let turn_m = change_m - self.change_m;
        (self.step_m, self.change_m) = (*displacement_m, change_m);
        let (square, change) = (displacement_m.dot(displacement_m), change_m.dot(&change_m));
        if square > 0.0 {
            // a smaller change is rounding, or the effect of a filter
            if self.long != PASSED && change >= self.shortest_m2 {
                let turn = turn_m.dot(&turn_m);
                let even = turn >= self.shortest_m2 && turn <= self.longest_m2;
                let fits = square <= self.longest_m2 || change <= self.longest_m2 || even;
                self.long = if fits { PASSED } else { self.long + 1 };
            }
            if self.equal >= REST {
                if square >= self.shortest_m2 && square <= self.longest_m2 {
                    self.short = PASSED;
                }
                self.gone_m = Vector3::zeros();
            }
            self.equal = 0;
            self.gone_m += displacement_m;
        } else {
            self.equal = self.equal.saturating_add(1);
            let gone_m2 = self.gone_m.dot(&self.gone_m);
            if self.equal == REST && self.short != PASSED && gone_m2 > 0.0 && gone_m2 < self.shortest_m2 {
                self.short += 1;
            }
        }
        match self.long == self.most_long || self.short == MOST {
            true => Err(Fault::UnitMismatch),
            false => Ok(()),
        }
    }

    /// Begins both checks anew.
    pub fn reset(&mut self) {
        let counted = if self.longest_m2 > 0.0 { 0 } else { PASSED };
        (self.equal, self.long, self.short) = (0, counted, counted);
        (self.step_m, self.change_m, self.gone_m) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT_M: f32 = 55e-6;

    /// Tick of the fault if a hand trembles at rest and its position is read in counts of `ratio *
    /// count_m`.
    fn trembles(count_m: f32, ratio: f32) -> Option<u16> {
        let mut watch = UnitWatch::build(count_m);
        let mut last_m = Vector3::<f32>::zeros();
        (0..10_000_u16).find(|&n| {
            let t_s = 1e-3 * f32::from(n);
            let aside_m = 80e-6 * libm::sinf(56.5 * t_s) + 300e-6 * libm::sinf(1.9 * t_s);
            let true_m = Vector3::new(aside_m, 0.3 * aside_m, 0.7 * aside_m);
            let read_m = true_m.map(|x| libm::floorf(x / COUNT_M) * COUNT_M * ratio);
            let displacement_m = read_m - last_m;
            last_m = read_m;
            watch.judge(&displacement_m, false).is_err()
        })
    }

    #[test]
    fn readings_in_another_unit_are_a_fault_and_in_the_profiles_they_are_not() {
        for ratio in [1000.0, 100.0, 10.0, 0.1, 0.01, 0.001] {
            let at = trembles(COUNT_M, ratio);
            assert!(at.is_some_and(|n| n < 1_500), "{ratio}: {at:?}");
        }
        for ratio in [0.4, 1.0, 2.5] {
            assert_eq!(trembles(COUNT_M, ratio), None, "{ratio}: a lever, not a unit");
        }
        assert_eq!(trembles(0.0, 10.0), None, "a profile without a count");
    }

    #[test]
    fn a_quick_start_from_rest_fits() {
        let mut watch = UnitWatch::build(COUNT_M);
        for start in 0..100_u8 {
            for n in 0..40_u8 {
                // 60 m/s^2 for ten ticks, then slowing down as fast, then rest
                let ticks = f32::from(if n < 10 { n } else { 20_u8.saturating_sub(n) });
                let displacement_m = Vector3::new(libm::roundf(60e-6 * ticks / COUNT_M) * COUNT_M, 0.0, 0.0);
                assert_eq!(watch.judge(&displacement_m, false), Ok(()), "start {start}");
            }
        }
    }

    #[test]
    fn a_motion_ends_with_a_rest_and_not_with_a_pause() {
        let step = |counts: f32| Vector3::new(counts * COUNT_M, 0.0, 0.0);
        let moved = |pauses: u8| {
            let mut watch = UnitWatch::build(COUNT_M);
            // steps of a tenth of a count with many equal readings in between: three equal ones are
            // a rest
            (0..30_u8).try_for_each(|_| {
                for _ in 0..5 {
                    watch.judge(&step(0.1), false)?;
                    (0..pauses).try_for_each(|_| watch.judge(&step(0.0), false))?;
                }
                (0..3).try_for_each(|_| watch.judge(&step(0.0), false))
            })
        };
        assert_eq!((moved(0), moved(1), moved(2)), (Ok(()), Ok(()), Ok(())), "half a count from rest to rest");
        assert_eq!(moved(3), Err(Fault::UnitMismatch), "a tenth of a count from rest to rest");
    }

    /// Runs this many motions of these steps [counts], each from rest to rest.
    fn motions(watch: &mut UnitWatch, times: u8, steps: [f32; 2]) -> Result<(), Fault> {
        (0..times).try_for_each(|_| {
            [0.0; 3]
                .into_iter()
                .chain(steps)
                .chain([0.0; 3])
                .try_for_each(|counts| watch.judge(&Vector3::new(counts * COUNT_M, 0.0, 0.0), false))
        })
    }

    #[test]
    fn a_motion_that_ends_where_it_began_says_nothing() {
        assert_eq!(motions(&mut UnitWatch::build(COUNT_M), 30, [0.1, -0.1]), Ok(()));
        assert_eq!(motions(&mut UnitWatch::build(COUNT_M), 8, [0.05, 0.05]), Err(Fault::UnitMismatch));
    }

    #[test]
    fn reset_forgets_the_motions_and_that_one_fitted() {
        let mut watch = UnitWatch::build(COUNT_M);
        assert_eq!(motions(&mut watch, 1, [1.0, 0.0]), Ok(()));
        assert_eq!(motions(&mut watch, 30, [10.0, 0.0]), Ok(()), "one fitted");
        watch.reset();
        assert_eq!(motions(&mut watch, 12, [10.0, 0.0]), Ok(()));
        watch.reset();
        assert_eq!(motions(&mut watch, 12, [10.0, 0.0]), Ok(()), "counted anew");
        assert_eq!(motions(&mut watch, 1, [10.0, 0.0]), Err(Fault::UnitMismatch));
        let mut ideal = UnitWatch::build(0.0);
        ideal.reset();
        assert_eq!(motions(&mut ideal, 30, [10.0, 0.0]), Ok(()), "no count to compare with");
    }

    #[test]
    fn a_hand_that_speeds_up_evenly_is_no_fault_on_any_encoder_and_a_grid_of_ten_counts_is() {
        for count_m in [10e-6, 20e-6, 55e-6, 60e-6] {
            for m_per_s2 in [20.0_f32, 60.0, 200.0] {
                for ratio in [1.0, 10.0] {
                    let mut watch = UnitWatch::build(count_m);
                    let mut last_m = 0.0;
                    // up to 1.5 m/s and on at that speed; a tenth of it if readings are ten times
                    // too long
                    let found = (1..2_000_u16).find(|&n| {
                        let (t_s, m_per_s) = (1e-3 * f32::from(n), 1.503 / ratio);
                        let speeds_s = m_per_s / (m_per_s2 / ratio);
                        let gone_m =
                            if t_s < speeds_s { 0.5 * m_per_s2 / ratio * t_s * t_s } else { m_per_s * (t_s - 0.5 * speeds_s) };
                        let read_m = libm::floorf(gone_m / count_m) * count_m * ratio;
                        let displacement_m = Vector3::new(read_m - last_m, 0.0, 0.0);
                        last_m = read_m;
                        watch.judge(&displacement_m, false).is_err()
                    });
                    assert_eq!(found.is_some(), ratio > 1.0, "{count_m} m, {m_per_s2} m/s^2, {ratio}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn a_hand_that_goes_round_fast_is_no_fault_on_any_encoder() {
        for count_m in [5e-6, 10e-6, 20e-6, 55e-6] {
            for (m_per_s, m_per_s2) in [(0.6_f32, 90.0), (1.0, 140.0), (1.45, 195.0)] {
                let mut watch = UnitWatch::build(count_m);
                let (radius_m, rad_per_tick) = (m_per_s * m_per_s / m_per_s2, 1e-3 * m_per_s2 / m_per_s);
                let read = |n: u16| {
                    let angle = rad_per_tick * f32::from(n);
                    let at_m = Vector3::new(libm::cosf(angle), libm::sinf(angle), 0.0) * radius_m;
                    at_m.map(|x| libm::floorf(x / count_m) * count_m)
                };
                // its first step is already at full speed
                for n in 1..1_000 {
                    let displacement_m = read(n) - read(n - 1);
                    assert_eq!(watch.judge(&displacement_m, false), Ok(()), "{count_m} m, {m_per_s2} m/s^2, tick {n}");
                }
            }
        }
    }

    #[test]
    fn a_held_reading_is_not_judged() {
        let mut watch = UnitWatch::build(COUNT_M);
        for n in 0..200_u8 {
            let counts = if n % 2 == 0 { 20.0 } else { -20.0 };
            assert_eq!(watch.judge(&Vector3::new(counts * COUNT_M, 0.0, 0.0), true), Ok(()), "reading {n}");
        }
    }

    #[test]
    fn a_step_that_fits_ends_the_watch_on_long_steps_alone() {
        let mut watch = UnitWatch::build(COUNT_M);
        // the first step of this motion is a tenth of a count, the second fits
        assert_eq!(motions(&mut watch, 1, [0.1, 3.0]), Ok(()));
        assert_eq!(motions(&mut watch, 8, [0.05, 0.05]), Err(Fault::UnitMismatch), "short motions still count");
    }

    #[test]
    fn a_step_of_a_few_counts_fits_however_it_differs_from_the_one_before() {
        let mut watch = UnitWatch::build(COUNT_M);
        for n in 0..200_u8 {
            let counts = if n % 2 == 0 { 20.0 } else { -4.0 };
            assert_eq!(watch.judge(&Vector3::new(counts * COUNT_M, 0.0, 0.0), false), Ok(()), "step {n}");
        }
    }

    #[test]
    fn a_first_step_of_a_count_ends_the_watch_on_short_motions() {
        let mut watch = UnitWatch::build(COUNT_M);
        assert_eq!(motions(&mut watch, 1, [1.0, 0.0]), Ok(()));
        assert_eq!(motions(&mut watch, 30, [0.05, 0.05]), Ok(()));
    }

    #[test]
    fn a_filtered_reading_is_no_fault() {
        let mut watch = UnitWatch::build(COUNT_M);
        let mut shown_m = 0.0_f32;
        for n in 0..20_000_u16 {
            let aim_m = if n % 400 < 200 { COUNT_M } else { 0.0 };
            let next_m = if (aim_m - shown_m).abs() < 1e-9 { aim_m } else { shown_m + 0.1 * (aim_m - shown_m) };
            let displacement_m = Vector3::new(next_m - shown_m, 0.0, 0.0);
            shown_m = next_m;
            assert_eq!(watch.judge(&displacement_m, false), Ok(()), "tick {n}");
        }
    }
}
