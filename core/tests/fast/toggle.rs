//! A reading that flips between two encoder counts: filtered where it is felt, and never far from
//! the reading.

use palpate::Vector3;
use palpate::haptic::toggle::Toggle;

const COUNT_M: f32 = 50e-6;
/// Force per count, large enough to be felt [N].
const FELT_N: f32 = 0.1;

/// A toggle filter in front of a patch whose force is in proportion to the position it is shown.
struct Shown {
    toggle: Toggle,
    axis: usize,
    n_per_count: f32,
}

impl Shown {
    fn new(axis: usize, n_per_count: f32) -> Self {
        Self { toggle: Toggle::new(COUNT_M), axis, n_per_count }
    }

    /// Position shown to the patch for a reading [counts].
    fn read(&mut self, counts: f32) -> f32 {
        let mut read_m = Vector3::zeros();
        read_m[self.axis] = counts * COUNT_M;
        let shown_m = self.toggle.show(&read_m);
        let shown = shown_m[self.axis] / COUNT_M;
        self.toggle.answered(&(shown_m * (self.n_per_count / COUNT_M)));
        shown
    }

    /// Flips between 0 and 1 for this many ticks; returns the last position shown.
    fn flip(&mut self, ticks: usize) -> f32 {
        (0..ticks).map(|n| self.read((n % 2) as f32)).last().expect("at least one")
    }
}

#[test]
fn a_felt_flip_is_shown_as_its_mean_on_every_axis() {
    for axis in 0..3 {
        let mut shown = Shown::new(axis, FELT_N);
        shown.flip(300);
        for n in 0..50 {
            let mean = shown.read((n % 2) as f32);
            assert!((mean - 0.5).abs() < 0.02, "axis {axis}: {mean}");
        }
    }
}

#[test]
fn a_flip_that_is_not_felt_is_shown_as_it_is_read() {
    let mut shown = Shown::new(2, 0.1 * FELT_N);
    assert!((0..400).all(|n| (shown.read((n % 2) as f32) - (n % 2) as f32).abs() < 1e-5));
}

#[test]
fn what_is_shown_never_lags_by_more_than_a_count_and_a_half() {
    // on a linkage an axis moves by parts of the counts of two joints: mostly at 0, now and then at
    // 1.5
    for high in [1.0_f32, 1.2, 1.4, 1.5, 1.6, 2.0, 3.0] {
        let mut shown = Shown::new(0, FELT_N);
        for n in 0..600 {
            let read = if n < 60 && n % 2 == 0 || n % 10 == 0 { high } else { 0.0 };
            let lag = (shown.read(read) - read).abs();
            assert!(lag <= 1.501, "{high} counts, tick {n}: {lag}");
        }
    }
}

#[test]
fn a_flip_that_ends_is_shown_as_it_is_read_after_two_hundred_ticks() {
    let mut shown = Shown::new(1, FELT_N);
    shown.flip(300);
    let late = (0..400).filter(|_| shown.read(1.0) != 1.0).count();
    assert_eq!(late, 200, "ticks");
    // the next count is a motion, not a flip
    assert!((shown.read(2.0) - 2.0).abs() < 1e-6 && (shown.read(1.0) - 1.0).abs() < 1e-6);
}

#[test]
fn flips_that_are_slow_are_shown_as_they_are_read() {
    // felt, but with a flip every 210 ticks the reading has left the boundary in between
    let mut shown = Shown::new(2, 40.0 * FELT_N);
    for n in 0..2_100 {
        let read = f32::from(n / 210 % 2 == 1);
        assert!((shown.read(read) - read).abs() < 1e-5, "tick {n}");
    }
}

#[test]
fn two_turns_begin_the_mean_and_one_does_not() {
    for sign in [1.0, -1.0] {
        let mut shown = Shown::new(0, FELT_N);
        // felt: meanwhile the force of another axis shakes
        for n in 0..200 {
            shown.toggle.answered(&Vector3::new(0.0, (n % 2) as f32, 0.0));
            shown.toggle.show(&Vector3::zeros());
        }
        shown.n_per_count = 20.0 * FELT_N;
        assert!((shown.read(sign) - sign).abs() < 1e-5, "a motion");
        assert!(shown.read(0.0).abs() < 1e-5, "one turn");
        let second = shown.read(sign);
        assert!((second * sign - 0.025).abs() < 1e-3, "two turns: {second}");
    }
}

/// A filter to which a shaking force was reported, but no reading yet.
fn shaken() -> Toggle {
    let mut toggle = Toggle::new(COUNT_M);
    (0..200_u8).for_each(|n| toggle.answered(&Vector3::new(0.0, f32::from(n % 2), 0.0)));
    toggle
}

#[test]
fn the_first_reading_is_no_motion() {
    let mut toggle = shaken();
    // the last of these is the first reversal, wherever the first reading lies
    for counts in [1.0, 0.0, 1.0] {
        let read_m = Vector3::repeat(counts * COUNT_M);
        assert_eq!(toggle.show(&read_m), read_m, "{counts} counts");
    }
    assert!(toggle.show(&Vector3::zeros()).x > 0.9 * COUNT_M, "the second turn begins the mean");
}

#[test]
fn turns_by_more_than_two_counts_are_no_flip() {
    let mut toggle = shaken();
    for counts in [0.0, 3.0, 0.0, 3.0, 0.0, 1.0] {
        let read_m = Vector3::repeat(counts * COUNT_M);
        assert_eq!(toggle.show(&read_m), read_m, "{counts} counts");
    }
}

#[test]
fn reset_forgets_the_flip() {
    let mut shown = Shown::new(0, FELT_N);
    shown.flip(300);
    shown.toggle.reset();
    for n in 0..6 {
        let read = (n % 2) as f32;
        assert!((shown.read(read) - read).abs() < 1e-5, "tick {n}: shown as it is read until it is felt anew");
    }
    let mut ideal = Toggle::new(0.0);
    for n in 0..600 {
        let read_m = Vector3::new(0.0, 0.0, (n % 2) as f32 * COUNT_M);
        assert_eq!(ideal.show(&read_m), read_m, "an ideal sensor does not flip");
        ideal.answered(&Vector3::new(0.0, 0.0, (n % 2) as f32));
    }
}

#[test]
fn a_strong_force_that_does_not_shake_is_no_flip_that_is_felt() {
    let mut toggle = Toggle::new(COUNT_M);
    for n in 0..400 {
        let read_m = Vector3::new(0.0, 0.0, (n % 2) as f32 * COUNT_M);
        assert_eq!(toggle.show(&read_m), read_m, "tick {n}");
        toggle.answered(&Vector3::new(0.0, 0.0, 0.5));
    }
}
