//! The runs of a campaign, counted by kind of fault.

use std::collections::BTreeMap;

use super::case::Case;
use super::state::Outcome;
use crate::closed_loop::faulty::FaultType;
use crate::closed_loop::faulty::list::FAULTS;

/// Bad runs that are remembered, of each kind.
const SHOWN: usize = 3;

/// One kind of fault.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Runs.
    pub runs: u64,
    /// Runs in which its moment came.
    pub injected: u64,
    /// Runs that ended in a fault.
    pub detected: u64,
    /// Ticks until the reaction, of every run that had one.
    pub reaction_ticks: Vec<u32>,
    /// Strongest force after it [N].
    pub peak_n: f32,
    /// Runs that broke an invariant.
    pub broken: u64,
    /// Runs in which something else followed than had to.
    pub wrong: u64,
    /// By number of the fault.
    pub faults: BTreeMap<u8, u64>,
    /// Some of the bad runs: what they were and what was bad.
    pub examples: Vec<String>,
}

/// One row a kind, in the order of [`FAULTS`].
#[derive(Clone, Debug)]
pub struct Table {
    /// The rows.
    pub rows: Vec<Row>,
}

impl Default for Table {
    fn default() -> Self {
        Self { rows: vec![Row::default(); FAULTS.len()] }
    }
}

impl Table {
    /// Counts one run.
    pub fn count(&mut self, case: &Case, outcome: &Outcome) {
        let Some(row) = self.rows.get_mut(case.fault) else { return };
        row.runs += 1;
        row.injected += u64::from(outcome.injected);
        row.detected += u64::from(outcome.fault.is_some());
        row.reaction_ticks.extend(outcome.reaction_ticks);
        row.peak_n = row.peak_n.max(outcome.peak_n);
        row.broken += u64::from(!outcome.broken.is_empty());
        row.wrong += u64::from(outcome.wrong.is_some());
        if let Some(fault) = outcome.fault {
            *row.faults.entry(fault as u8).or_default() += 1;
        }
        if (outcome.wrong.is_some() || !outcome.broken.is_empty()) && row.examples.len() < SHOWN {
            row.examples.push(format!(
                "{}: {} {} {:?}+{} on the {}: {:?}, {:?}, {:?}, {:?} ticks",
                case.kind().id,
                case.hand.id,
                case.motion.id,
                case.moment,
                case.after_ticks,
                if case.on_patch { "patch" } else { "wall" },
                outcome.wrong,
                outcome.broken,
                outcome.fault,
                outcome.reaction_ticks,
            ));
        }
    }

    /// Adds another table.
    pub fn add(&mut self, other: &Self) {
        for (row, more) in self.rows.iter_mut().zip(&other.rows) {
            row.runs += more.runs;
            row.injected += more.injected;
            row.detected += more.detected;
            row.reaction_ticks.extend(&more.reaction_ticks);
            row.peak_n = row.peak_n.max(more.peak_n);
            row.broken += more.broken;
            row.wrong += more.wrong;
            for (fault, count) in &more.faults {
                *row.faults.entry(*fault).or_default() += count;
            }
            row.examples.extend(more.examples.iter().cloned());
            row.examples.truncate(SHOWN);
        }
    }

    /// Each kind with its row.
    pub fn kinds(&self) -> impl Iterator<Item = (&'static FaultType, &Row)> {
        FAULTS.iter().zip(&self.rows)
    }

    /// Runs in which something was bad: an invariant broken, or not what had to follow.
    #[must_use]
    pub fn bad(&self) -> u64 {
        self.rows.iter().map(|r| r.broken + r.wrong).sum()
    }

    /// Some of them.
    #[must_use]
    pub fn examples(&self) -> Vec<&str> {
        self.rows.iter().flat_map(|r| &r.examples).map(String::as_str).collect()
    }
}

impl Row {
    /// The latest reaction [ticks].
    #[must_use]
    pub fn latest_ticks(&self) -> Option<u32> {
        self.reaction_ticks.iter().copied().max()
    }

    /// Returns the faults that the runs ended in, as text: number of the fault and how often.
    #[must_use]
    pub fn ends(&self) -> String {
        let of = |(fault, count): (&u8, &u64)| format!("{fault}:{count}");
        self.faults.iter().map(of).collect::<Vec<_>>().join(" ")
    }
}
