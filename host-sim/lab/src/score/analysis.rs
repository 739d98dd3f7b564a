//! Statistics of the values: spread of each group in each phase, change due to the training, and
//! differences between groups.

use serde::Serialize;

use super::statistics::{Permutation, Spread, permutation_test};
use super::{Evaluation, Phase};

/// One group in one phase.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// Label of the group.
    pub group: String,
    /// Before or after the training.
    pub phase: Phase,
    /// Mean and spread of the values.
    #[serde(flatten)]
    pub spread: Spread,
}

/// Change of the value, after minus before, over the interns of a group who have both.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// Label of the group.
    pub group: String,
    /// Spread of the changes.
    #[serde(flatten)]
    pub spread: Spread,
}

/// Difference between two groups, first minus second.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contrast {
    /// Compared quantity: `before`, `after` or `change`.
    pub what: &'static str,
    /// Label of the first group.
    pub first: String,
    /// Label of the second group.
    pub second: String,
    /// Difference of the means.
    pub difference: f64,
    /// Two-sided test of that difference.
    #[serde(flatten)]
    pub test: Permutation,
}

/// The whole analysis, with groups in the order in which they first appear.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Analysis {
    /// One cell for each group and phase.
    pub cells: Vec<Cell>,
    /// One change for each group that has interns with marks in both phases.
    pub changes: Vec<Change>,
    /// Contrasts of every pair of groups, in each phase and in the change.
    pub contrasts: Vec<Contrast>,
}

impl Analysis {
    /// Analyses any number of evaluations.
    #[must_use]
    pub fn of(all: &[Evaluation]) -> Self {
        let groups = groups(all);
        let mut found = Self { cells: Vec::new(), changes: Vec::new(), contrasts: Vec::new() };
        for &group in &groups {
            for phase in Phase::ALL {
                if let Some(spread) = Spread::of(&values(all, group, phase)) {
                    found.cells.push(Cell { group: group.into(), phase, spread });
                }
            }
            if let Some(spread) = Spread::of(&changes(all, group)) {
                found.changes.push(Change { group: group.into(), spread });
            }
        }
        for (n, first) in groups.iter().enumerate() {
            for second in groups.iter().skip(n + 1) {
                for phase in Phase::ALL {
                    let of = |group| values(all, group, phase);
                    found.contrasts.extend(contrast(phase.name(), (first, &of(first)), (second, &of(second))));
                }
                found.contrasts.extend(contrast("change", (first, &changes(all, first)), (second, &changes(all, second))));
            }
        }
        found
    }
}

/// Labels of the groups in the order in which they first appear.
#[must_use]
pub fn groups(all: &[Evaluation]) -> Vec<&str> {
    let mut groups: Vec<&str> = Vec::new();
    for e in all {
        if !groups.contains(&e.group.as_str()) {
            groups.push(&e.group);
        }
    }
    groups
}

/// Values of one group in one phase, in the order of the file.
#[must_use]
pub fn values(all: &[Evaluation], group: &str, phase: Phase) -> Vec<f64> {
    all.iter().filter(|e| e.group == group && e.phase == phase).map(|e| e.value).collect()
}

fn changes(all: &[Evaluation], group: &str) -> Vec<f64> {
    let of = |phase| all.iter().filter(move |e| e.group == group && e.phase == phase);
    of(Phase::Before)
        .filter_map(|before| of(Phase::After).find(|after| after.intern == before.intern).map(|after| after.value - before.value))
        .collect()
}

fn contrast(what: &'static str, first: (&str, &[f64]), second: (&str, &[f64])) -> Option<Contrast> {
    let test = permutation_test(first.1, second.1)?;
    let difference = Spread::of(first.1)?.mean - Spread::of(second.1)?.mean;
    Some(Contrast { what, first: first.0.into(), second: second.0.into(), difference, test })
}
