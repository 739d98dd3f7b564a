//! Table 1 of paper 004: the values of 20 interns before and after the training, as printed, and a
//! check of equation (14) against them.
//!
//! The marks behind the values are not printed. Three statements can be checked: every value is one
//! that (14) gives for integer marks; the groups do not differ before the training; and after it
//! the first group (virtual training) is above the second (trained on a real abdomen).

use super::statistics::permutation_test;
use super::{PAPER_WEIGHTS, value};

/// Rows of Table 1: groups 1 and 2 before the training, groups 1 and 2 after it.
pub const PRINTED: [[f64; 4]; 10] = [
    [0.525, 0.400, 0.955, 0.790],
    [0.500, 0.460, 0.945, 0.795],
    [0.400, 0.500, 0.955, 0.725],
    [0.375, 0.320, 0.900, 0.820],
    [0.400, 0.400, 1.000, 0.670],
    [0.600, 0.545, 0.955, 0.840],
    [0.590, 0.300, 0.900, 0.900],
    [0.510, 0.400, 1.000, 0.710],
    [0.415, 0.435, 0.855, 0.790],
    [0.500, 0.480, 0.920, 0.795],
];

/// Rounding error of the printed values, which have three decimals.
const ROUNDING: f64 = 5e-4;

/// Probability below which a difference between groups is not attributed to chance.
const SIGNIFICANT: f64 = 0.05;

/// Number of the 11^3 combinations of integer marks for which (14) rounds to a printed value.
pub fn marks_for(printed: f64, weights: [f64; 3]) -> usize {
    let all = (0..=10_u8).flat_map(|a| (0..=10_u8).flat_map(move |b| (0..=10_u8).map(move |c| [a, b, c])));
    all.filter(|marks| (value(marks.map(f64::from), weights) - printed).abs() <= ROUNDING + 1e-9).count()
}

/// Result of the check.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Mean of each column.
    pub means: [f64; 4],
    /// Number of values that (14) gives for no integer marks.
    pub unattainable: usize,
    /// Difference of the means before the training, group 1 minus group 2, and the probability of
    /// such a difference by chance.
    pub before: (f64, f64),
    /// Difference of the means after the training, group 1 minus group 2, and the probability of
    /// such a difference by chance.
    pub after: (f64, f64),
}

impl Check {
    /// Examines the table with the weights of the paper.
    pub fn run() -> Self {
        let column = |n: usize| PRINTED.map(|row| row[n]);
        let mean = |n: usize| column(n).iter().sum::<f64>() / PRINTED.len() as f64;
        let contrast = |first: usize, second: usize| {
            let test = permutation_test(&column(first), &column(second));
            (mean(first) - mean(second), test.map_or(f64::NAN, |test| test.p))
        };
        Self {
            means: [0, 1, 2, 3].map(mean),
            unattainable: PRINTED.iter().flatten().filter(|v| marks_for(**v, PAPER_WEIGHTS) == 0).count(),
            before: contrast(0, 1),
            after: contrast(2, 3),
        }
    }

    /// Claims of the paper and of (14), and whether the printed values agree with them.
    pub fn claims(&self) -> [(&'static str, bool); 3] {
        [
            ("every value is one that (14) gives for whole marks", self.unattainable == 0),
            ("before: the groups differ no more than by chance", self.before.1 > SIGNIFICANT),
            ("after: group 1 is above group 2, more than by chance", self.after.0 > 0.0 && self.after.1 < SIGNIFICANT),
        ]
    }
}
