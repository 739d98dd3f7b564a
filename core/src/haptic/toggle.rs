//! Removes the limit cycle that occurs when the hand rests on the boundary between two encoder
//! counts.
//!
//! The reading then flips between the two, and every flip is rendered as a step in depth. The force
//! of that step is the count times the dynamic stiffness, ten times the static one, and on a light
//! device without friction it is enough to cause the next flip. While an axis flips between two
//! neighbouring counts *and* the force shakes with it, the patch is given a low-pass filtered
//! position, which settles where the force balances the hand. The raw reading returns as soon as it
//! is more than 1.5 counts away, so the filter can never lag a real motion by more than that; a lag
//! behind a motion would give the hand energy. A flip that does not shake the force is left alone:
//! on a handle held by neither friction nor grip it provides the damping.
//!
//! * in: position read [m], force of the patch [N]
//! * out: position to show to the patch [m], within 1.5 counts of it along every axis
//! * cost: 80 instructions of a Cortex-M4F, estimated
//! * failures: none

use nalgebra::Vector3;

/// Largest change of the reading that counts as a flip, and largest distance of the filtered
/// position from the reading, in counts (1). On a linkage, an axis moves by parts of the counts of
/// two joints.
/// Source: derived; above the diagonal of two counts, 1.41, and below two counts, which are a
/// motion: at 2.1 `what_moves_is_shown_as_it_is_read` fails.
pub(super) const PAIR: f32 = 1.5;
/// Number of reversals in a row after which the filtered position is shown.
/// Source: chosen; the fewest that are no single flip.
const TURNS: u8 = 2;
/// Number of ticks without a flip after which the reading has left the boundary.
/// Source: derived; five time constants of the filter, after which the shown position is the mean
/// but for 0.7 % (`a_flip_that_ends_is_shown_as_it_is_read_after_two_hundred_ticks`).
const QUIET: u16 = 200;
/// Weight of the newest reading per tick (1): a time constant of 40 ms, four to ten periods of the
/// limit cycle.
/// Source: measured; with 40 ms a toggling count shakes with 0.2 mN where it shook with 21
/// (DECISIONS.md).
const SHARE: f32 = 0.025;

/// The force shakes if its change per tick, low-passed with `SHARE`, exceeds this [N]:
/// about 18 mN RMS.
/// Source: chosen; below the 20 mN from which `palpate loop` calls a force a vibration.
const SHAKES_N: f32 = 15e-3;

/// One axis: the position that was read and the one that is shown.
#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    read_m: f32,
    shown_m: f32,
    /// Last change of the reading [m].
    displacement_m: f32,
    since: u16,
    turns: u8,
    /// True if the filtered position is shown.
    mean: bool,
}

/// Filters every axis whose reading flips.
#[derive(Clone, Copy, Debug)]
pub struct Toggle {
    count_m: f32,
    axes: Option<[Axis; 3]>,
    force_n: Vector3<f32>,
    /// Change of the force per tick, low-passed [N].
    shakes_n: f32,
}

impl Toggle {
    /// Creates the filter for a sensor with this count [m]; zero for an ideal sensor, whose
    /// readings never flip.
    #[must_use]
    pub const fn new(count_m: f32) -> Self {
        Self { count_m, axes: None, force_n: Vector3::new(0.0, 0.0, 0.0), shakes_n: 0.0 }
    }

    /// Resets the filter, after a fault and when the loop is armed.
    pub fn reset(&mut self) {
        *self = Self::new(self.count_m);
    }

    /// Takes the patch's force [N] for the position that was shown, once per tick.
    pub fn answered(&mut self, force_n: &Vector3<f32>) {
        let change_n = super::length(&(force_n - self.force_n));
        self.force_n = *force_n;
        self.shakes_n += (change_n - self.shakes_n) * SHARE;
    }

    /// Returns the position to show to the patch [m]; call this in every tick.
    pub fn show(&mut self, read_m: &Vector3<f32>) -> Vector3<f32> {
        let fresh = || [read_m.x, read_m.y, read_m.z].map(|m| Axis { read_m: m, ..Axis::default() });
        let axes = self.axes.get_or_insert_with(fresh);
        let mut shown_m = *read_m;
        for ((axis, m), shown_m) in axes.iter_mut().zip(read_m.iter()).zip(shown_m.iter_mut()) {
            *shown_m = axis.show(*m, self.count_m, self.shakes_n > SHAKES_N);
        }
        shown_m
    }
}

impl Axis {
    fn show(&mut self, read_m: f32, count_m: f32, shakes: bool) -> f32 {
        let displacement_m = read_m - self.read_m;
        self.read_m = read_m;
        if displacement_m != 0.0 {
            let turned = displacement_m * self.displacement_m < 0.0 && displacement_m.abs() <= PAIR * count_m;
            self.turns = if turned { self.turns.saturating_add(1) } else { 0 };
            (self.displacement_m, self.since) = (displacement_m, 0);
        } else {
            self.since = self.since.saturating_add(1);
            if self.since > QUIET {
                self.turns = 0;
            }
        }
        let off_m = read_m - self.shown_m;
        let on_edge = self.turns >= TURNS && off_m.abs() <= PAIR * count_m;
        self.mean = on_edge && (self.mean || shakes);
        self.shown_m = if self.mean { self.shown_m + off_m * SHARE } else { read_m };
        self.shown_m
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    const COUNT_M: f32 = 50e-6;

    /// Positions shown to a patch whose force changes by this much per count [N].
    fn shown(readings: impl Iterator<Item = i16>, n_per_count: f32) -> Vec<f32> {
        let mut toggle = Toggle::new(COUNT_M);
        let mut show = |n| {
            let shown = toggle.show(&Vector3::new(0.0, 0.0, COUNT_M * f32::from(n))).z / COUNT_M;
            toggle.answered(&Vector3::new(0.0, 0.0, shown * n_per_count));
            shown
        };
        readings.map(&mut show).collect()
    }

    #[test]
    fn what_moves_is_shown_as_it_is_read() {
        let moves = || (0..400_i16).map(|n| if n < 200 { n / 3 } else { (400 - n) / 3 }).chain([0, 2, 0, 2, 0]);
        for (seen, read) in shown(moves(), 0.1).iter().zip(moves()) {
            assert!((seen - f32::from(read)).abs() < 1e-4, "{seen} {read}");
        }
    }

    #[test]
    fn a_toggling_count_is_shown_as_its_mean_and_a_third_one_as_itself() {
        // three ticks below, one above
        let seen = shown((0..400_i16).map(|n| i16::from(n % 4 == 3)).chain([2, 3]), 0.05);
        let settled = &seen[200..400];
        assert!(settled.iter().all(|s| (s - 0.25).abs() < 0.03), "{settled:?}");
        assert!((seen[400] - 2.0).abs() + (seen[401] - 3.0).abs() < 1e-4);
    }

    #[test]
    fn a_toggle_that_is_not_felt_is_shown() {
        let toggles = || (0..400_i16).map(|n| i16::from(n % 4 == 3));
        assert!(shown(toggles(), 0.01).iter().zip(toggles()).all(|(s, r)| (s - f32::from(r)).abs() < 1e-4));
    }

    #[test]
    fn a_count_that_toggled_is_not_late_once_it_creeps_on() {
        // a toggle, then a count every 100 ms
        let creep = || (0..20_i16).map(|n| n / 3 % 2).chain((0..1000).map(|n| 1 + n / 100));
        let late = shown(creep(), 0.1).iter().zip(creep()).skip(220).filter(|(s, r)| (**s - f32::from(*r)).abs() > 1e-3).count();
        assert_eq!(late, 0, "ticks");
    }

    #[test]
    fn what_is_shown_is_never_more_than_a_count_and_a_half_away() {
        // a toggle that shakes, then jumps of one, two, four counts and back
        let jumps = || [1_i16, 2, 4, -4, -2].into_iter().flat_map(|to| (0..200_i16).map(|n| i16::from(n % 4 == 3)).chain([to]));
        for (seen, read) in shown(jumps(), 0.05).iter().zip(jumps()) {
            assert!((seen - f32::from(read)).abs() < 1.51, "{seen} {read}");
        }
    }

    #[test]
    fn a_reading_that_no_longer_toggles_is_shown_as_read_after_a_fifth_of_a_second() {
        let seen = shown((0..400_i16).map(|n| i16::from(n % 4 == 3)).chain((0..202).map(|_| 0)), 0.05);
        assert!(seen[450] > 1e-4, "{}", seen[450]);
        assert_eq!(seen[601], 0.0);
    }

    #[test]
    fn a_toggle_that_drifts_away_is_never_shown_late_by_more() {
        // a linkage's steps, one and a half counts up and one down, after a toggle on the spot
        let mut toggle = Toggle::new(COUNT_M);
        let (mut read, mut means) = (0.0_f32, 0);
        for n in 0..400_u16 {
            read += if n % 2 == 1 {
                -1.0
            } else if n < 200 {
                1.0
            } else {
                1.5
            };
            let seen = toggle.show(&Vector3::new(0.0, 0.0, COUNT_M * read)).z / COUNT_M;
            toggle.answered(&Vector3::new(0.0, 0.0, 0.05 * read));
            means += i32::from((seen - read).abs() > 0.1);
            assert!((seen - read).abs() < 1.51, "tick {n}: {seen} {read}");
        }
        assert!(means > 100, "{means} ticks showed a mean");
    }
}
