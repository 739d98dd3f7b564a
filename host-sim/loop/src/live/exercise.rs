//! Find the nodule: a stiffer ball somewhere under the surface, found by pressing, and scored.
//!
//! In equation (14) of paper 004 three physicians give marks from 0 to 10; here three measurements
//! replace them, with the same weights: the distance of the answer (0.45, the chief's weight), the
//! strongest press (0.35) and the time (0.20). The mark of the place also multiplies the sum, since
//! a gentle and quick answer beside the nodule is worth nothing.

use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

use super::choice::Nodule;

/// Full mark of a physician in paper 004.
const FULL_MARK: f64 = 10.0;
/// Weights of the three marks: chief, associate chief and attending physician of paper 004.
const WEIGHTS: [f64; 3] = [0.45, 0.35, 0.20];
/// Largest distance of the nodule from the middle, where the patch's mesh is fine [m].
const REACH_M: f64 = 14e-3;
/// Distance between answer and nodule up to which an answer earns the full mark, and from which on
/// it earns none [m]; an answer that is not over the nodule earns none either.
const NEAR_M: [f64; 2] = [3e-3, 9e-3];
/// Strongest press that earns the full mark, and weakest that earns none [N].
const GENTLE_N: [f64; 2] = [0.4, 1.5];
/// Longest time that earns the full mark, and shortest that earns none [s].
const SOON_S: [f64; 2] = [20.0, 120.0];

/// A running exercise.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Exercise {
    /// Nodule to be found.
    pub hidden: Nodule,
}

/// Result of the exercise.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Found {
    /// Distance from the answer to the nodule, along the surface [m].
    pub apart_m: f64,
    /// Whether the answer is over the nodule.
    pub found: bool,
    /// Strongest press [N].
    pub peak_n: f64,
    /// Time taken [s].
    pub time_s: f64,
    /// Marks from 0 to 10: place, gentleness, time.
    pub marks: [f64; 3],
    /// Sum of equation (14) with the full mark for the place, times the share of that mark, from 0
    /// to 1.
    pub score: f64,
}

impl Exercise {
    /// Hides a nodule; every seed gives another place.
    #[must_use]
    pub fn hide(seed: u64) -> Self {
        let mut random = SplitMix64::seed_from_u64(seed);
        let mut share = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let (from_m, turn) = (REACH_M * (0.15 + 0.85 * share()).sqrt(), std::f64::consts::TAU * share());
        let place_m = [from_m * turn.cos(), from_m * turn.sin()];
        Self { hidden: Nodule { place_m, depth_m: 9e-3 + 2e-3 * share(), radius_m: 6e-3, ratio: 10.0 } }
    }

    /// Scores an answer at a position on the surface [m].
    #[must_use]
    pub fn judge(&self, place_m: [f64; 2], peak_n: f64, time_s: f64) -> Found {
        let [x, y] = self.hidden.place_m;
        let apart_m = (place_m[0] - x).hypot(place_m[1] - y);
        let mark = |value: f64, [full, none]: [f64; 2]| FULL_MARK * ((none - value) / (none - full)).clamp(0.0, 1.0);
        let found = apart_m <= self.hidden.radius_m;
        let place = if found { mark(apart_m, NEAR_M) } else { 0.0 };
        let marks = [place, mark(peak_n, GENTLE_N), mark(time_s, SOON_S)];
        let [place, gentle, soon] = marks.map(|mark| mark / FULL_MARK);
        let score = place * (WEIGHTS[0] + gentle * WEIGHTS[1] + soon * WEIGHTS[2]);
        Found { apart_m, found, peak_n, time_s, marks, score }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_nodules_differ_and_lie_where_the_mesh_is_fine() {
        let all: Vec<Nodule> = (0..50).map(|seed| Exercise::hide(seed).hidden).collect();
        for (n, one) in all.iter().enumerate() {
            assert!(one.place_m[0].hypot(one.place_m[1]) <= REACH_M && one.depth_m - one.radius_m > 2e-3);
            assert!(all.iter().skip(n + 1).all(|other| other.place_m != one.place_m));
        }
    }

    #[test]
    fn the_place_multiplies_equation_14_of_the_other_marks() {
        let exercise = Exercise::hide(7);
        let at = exercise.hidden.place_m;
        assert_eq!(exercise.judge(at, 0.3, 10.0).score, 1.0);
        let late = exercise.judge(at, 0.3, 70.0);
        assert!((late.marks[2] - 5.0).abs() < 1e-12 && (late.score - 0.9).abs() < 1e-12);
        let aside = exercise.judge([at[0] + 4.5e-3, at[1]], 0.3, 10.0);
        assert!((aside.marks[0] - 7.5).abs() < 1e-9 && (aside.score - 0.75).abs() < 1e-9, "{aside:?}");
        let missed = exercise.judge([at[0] + 0.03, at[1]], 9.0, 200.0);
        assert_eq!((missed.score, missed.marks), (0.0, [0.0; 3]));
    }

    #[test]
    fn a_gentle_and_quick_guess_beside_the_nodule_has_not_found_it() {
        let exercise = Exercise::hide(7);
        let [x, y] = exercise.hidden.place_m;
        let guess = |apart_m: f64| exercise.judge([x + apart_m, y], 0.0, 1.0);
        let (beside, over) = (guess(6.1e-3), guess(5.9e-3));
        assert!(!beside.found && beside.marks == [0.0, 10.0, 10.0] && beside.score == 0.0, "{beside:?}");
        assert!(over.found && over.marks[0] > 5.0, "{over:?}");
    }
}
