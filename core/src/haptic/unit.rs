//! Compares the encoder's steps with the profile: a unit or a scale that is wrong by ten or more.
//!
//! A hand that starts from rest cannot skip counts: at 60 m/s^2 it crosses the first count of 55 um
//! at 0.08 m/s, and the first new reading is one or two counts away. A hand at rest trembles by a
//! count or two. So if the first step of every motion is longer than five counts of the profile, or
//! if whole motions are shorter than a fifth of a count, eight times in a row without one that
//! fits, the readings are in another unit than the profile, or the profile's count is not the
//! encoder's. The first motion that fits ends the watch until the next fault: levers and gears make
//! counts at the probe differ by a factor of two or three, not ten.
//!
//! Not judged: a device whose profile says no count (an ideal sensor), and a driver that
//! interpolates or filters so that readings never rest or begin with a part of a step. A unit that
//! is wrong by 1000 leaves the workspace or lands here. A mirrored axis does not show in the length
//! of a step.
//!
//! * in: displacement between two readings [m]
//! * out: nothing
//! * cost: 30 instructions of a Cortex-M4F until a motion fits, 5 after it, estimated
//! * may fail: [`Fault::UnitMismatch`]

use nalgebra::Vector3;

use crate::fault::Fault;

/// Equal readings in a row that are a rest.
const REST: u8 = 3;
/// Steps this many times longer or shorter than a count do not fit the profile (1).
const FACTOR: f32 = 5.0;
/// Motions in a row that do not fit, without one that does, that are a fault.
const MOTIONS: u8 = 8;

/// Watches motions from rest to rest.
#[derive(Clone, Copy, Debug)]
pub struct UnitWatch {
    /// Square of the shortest and longest step that fits [m^2].
    shortest_m2: f32,
    longest_m2: f32,
    /// A motion fitted, or there is nothing to compare with.
    passed: bool,
    /// Equal readings in a row.
    equal: u8,
    /// Displacement since the last rest [m].
    gone_m: Vector3<f32>,
    /// The first step after the last rest was too long.
    coarse: bool,
    /// Motions that were too long and too short.
    bad: [u8; 2],
}

impl UnitWatch {
    /// For an encoder with this count [m]; zero if the profile says none.
    #[must_use]
    pub fn build(count_m: f32) -> Self {
        let (shortest_m, longest_m) = (count_m / FACTOR, count_m * FACTOR);
        Self {
            shortest_m2: shortest_m * shortest_m,
            longest_m2: longest_m * longest_m,
            passed: count_m <= 0.0,
            equal: 0,
            gone_m: Vector3::zeros(),
            coarse: false,
            bad: [0; 2],
        }
    }

    /// One reading, `displacement_m` from the one before; `held` if it is that one again.
    ///
    /// # Errors
    /// [`Fault::UnitMismatch`].
    pub fn judge(&mut self, displacement_m: &Vector3<f32>, held: bool) -> Result<(), Fault> {
        if self.passed || held {
            return Ok(());
        }
        let square = displacement_m.dot(displacement_m);
        if square > 0.0 {
            if self.equal >= REST {
                self.coarse = square > self.longest_m2;
                self.passed = !self.coarse && square >= self.shortest_m2;
                self.gone_m = Vector3::zeros();
            }
            self.equal = 0;
            self.gone_m += displacement_m;
            return Ok(());
        }
        self.equal = self.equal.saturating_add(1);
        if self.equal != REST {
            return Ok(());
        }
        let gone_m2 = self.gone_m.dot(&self.gone_m);
        let [coarse, fine] = &mut self.bad;
        if self.coarse {
            *coarse = coarse.saturating_add(1);
        } else if gone_m2 > 0.0 && gone_m2 < self.shortest_m2 {
            *fine = fine.saturating_add(1);
        }
        (self.coarse, self.gone_m) = (false, Vector3::zeros());
        match *coarse >= MOTIONS || *fine >= MOTIONS {
            true => Err(Fault::UnitMismatch),
            false => Ok(()),
        }
    }

    /// Judges anew.
    pub fn reset(&mut self) {
        self.passed = self.longest_m2 <= 0.0;
        (self.equal, self.coarse, self.bad) = (0, false, [0; 2]);
        self.gone_m = Vector3::zeros();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT_M: f32 = 55e-6;

    /// Tick of the fault when a hand trembles at rest, its position read in counts of
    /// `ratio * count_m`.
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
                // 60 m/s^2 for ten ticks, then as slow again, then rest
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
            // steps of a tenth of a count with so many equal readings in between: three of them are
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

    /// So many motions of these steps [counts], each from rest to rest.
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
        assert_eq!(motions(&mut watch, 7, [10.0, 0.0]), Ok(()));
        watch.reset();
        assert_eq!(motions(&mut watch, 7, [10.0, 0.0]), Ok(()), "counted anew");
        assert_eq!(motions(&mut watch, 1, [10.0, 0.0]), Err(Fault::UnitMismatch));
        let mut ideal = UnitWatch::build(0.0);
        ideal.reset();
        assert_eq!(motions(&mut ideal, 30, [10.0, 0.0]), Ok(()), "no count to compare with");
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
