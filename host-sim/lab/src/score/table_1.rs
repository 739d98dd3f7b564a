//! Table 1 of paper 004: the values of 20 interns before and after the training, as printed, and a
//! check of equation (14) against them.
//!
//! The marks behind the values are not printed. Three statements can be checked: every value is one
//! that (14) gives for integer marks; the groups do not differ before the training; and after it
//! the first group (virtual training) is above the second (trained on a real abdomen).

use serde::Serialize;

use super::statistics::Spread;
use super::{Analysis, Evaluation, Phase, Weights};

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

/// Group and phase of each column of [`PRINTED`].
pub const COLUMNS: [(&str, Phase); 4] = [("1", Phase::Before), ("2", Phase::Before), ("1", Phase::After), ("2", Phase::After)];

/// Rounding error of the printed values, which have three decimals.
const ROUNDING: f64 = 5e-4;

/// Probability below which a difference between groups is not attributed to chance.
const SIGNIFICANT: f64 = 0.05;

/// The printed values, group by group.
#[must_use]
pub fn evaluations() -> Vec<Evaluation> {
    let of = |column: usize| {
        let (group, phase) = COLUMNS[column];
        let row = move |(n, row): (usize, &[f64; 4])| Evaluation {
            group: group.into(),
            phase,
            intern: (n + 1).to_string(),
            value: row[column],
        };
        PRINTED.iter().enumerate().map(row)
    };
    (0..4).flat_map(of).collect()
}

/// Number of the 11^3 combinations of integer marks for which (14) rounds to a printed value, and
/// the first of them.
#[must_use]
pub fn marks_for(printed: f64, weights: &Weights) -> (usize, Option<[u8; 3]>) {
    let all = (0..=10_u8).flat_map(|a| (0..=10_u8).flat_map(move |b| (0..=10_u8).map(move |c| [a, b, c])));
    let mut hits = all.filter(|m| (weights.value(m.map(f64::from)) - printed).abs() <= ROUNDING + 1e-9);
    let first = hits.next();
    (usize::from(first.is_some()) + hits.count(), first)
}

/// One column of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Column {
    /// Group of the column.
    pub group: &'static str,
    /// Phase of the column.
    pub phase: Phase,
    /// Spread of the values.
    #[serde(flatten)]
    pub spread: Spread,
    /// Number of values that (14) gives for some integer marks.
    pub attainable: usize,
    /// Values that (14) does not give for any integer marks.
    pub unattainable: Vec<f64>,
}

/// Result of the check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// The four columns.
    pub columns: Vec<Column>,
    /// Difference of the means before the training, group 1 minus group 2, and the probability of
    /// such a difference by chance.
    pub before: (f64, f64),
    /// Difference of the means after the training, group 1 minus group 2, and the probability of
    /// such a difference by chance.
    pub after: (f64, f64),
    /// Share of pairs (one intern of each group) in which the intern of group 1 has the higher
    /// value after the training.
    pub pairs_above_after: f64,
}

impl Check {
    /// Examines the table with the weights of the paper.
    #[must_use]
    pub fn run(weights: &Weights) -> Self {
        let all = evaluations();
        let columns = COLUMNS.iter().enumerate().filter_map(|(n, &(group, phase))| {
            let values: Vec<f64> = PRINTED.iter().map(|row| row[n]).collect();
            let unattainable: Vec<f64> = values.iter().copied().filter(|v| marks_for(*v, weights).0 == 0).collect();
            let attainable = values.len() - unattainable.len();
            Some(Column { group, phase, spread: Spread::of(&values)?, attainable, unattainable })
        });
        let contrasts = Analysis::of(&all).contrasts;
        let of = |what| contrasts.iter().find(|c| c.what == what).map_or((f64::NAN, f64::NAN), |c| (c.difference, c.test.p));
        let pairs = PRINTED.iter().flat_map(|a| PRINTED.iter().map(move |b| a[2] > b[3]));
        Self {
            columns: columns.collect(),
            before: of(Phase::Before.name()),
            after: of(Phase::After.name()),
            pairs_above_after: pairs.filter(|above| *above).count() as f64 / (PRINTED.len() * PRINTED.len()) as f64,
        }
    }

    /// Claims of the paper and of (14), and whether the printed values agree with them.
    #[must_use]
    pub fn claims(&self) -> [(&'static str, bool); 4] {
        [
            ("20 interns in two groups of 10", self.columns.iter().all(|c| c.spread.count == 10)),
            ("every value is one that (14) gives for whole marks", self.columns.iter().all(|c| c.unattainable.is_empty())),
            ("before: the groups differ no more than by chance", self.before.1 > SIGNIFICANT),
            ("after: group 1 is above group 2, more than by chance", self.after.0 > 0.0 && self.after.1 < SIGNIFICANT),
        ]
    }
}
