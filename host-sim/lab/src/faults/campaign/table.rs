//! The runs of a campaign, counted by kind of fault.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::case::Case;
use super::state::Outcome;
use crate::faults::faulty::FaultType;
use crate::faults::faulty::list::FAULTS;

/// Number of bad runs that are recorded as text, per kind of fault.
const SHOWN: usize = 3;

/// Results for one kind of fault. All of them are counts or maxima, so the order in which rows are
/// added does not matter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Number of runs.
    pub runs: u64,
    /// Runs in which the fault was injected.
    pub injected: u64,
    /// Runs that the loop ended with a fault.
    pub detected: u64,
    /// Number of runs for each reaction time [ticks].
    pub reaction_ticks: BTreeMap<u32, u64>,
    /// Largest force after the injected fault [N].
    pub peak_n: f32,
    /// Runs that broke an invariant.
    pub broken: u64,
    /// Runs without the required reaction.
    pub wrong: u64,
    /// Number of runs that ended in each fault, by the number of the fault.
    pub faults: BTreeMap<u8, u64>,
    /// The bad runs with the lowest numbers: number of the run, and description with the violation.
    pub examples: Vec<(u64, String)>,
}

/// Results of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// One row per kind of fault, in the order of [`FAULTS`].
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
        if let Some(ticks) = outcome.reaction_ticks {
            *row.reaction_ticks.entry(ticks).or_default() += 1;
        }
        row.peak_n = row.peak_n.max(outcome.peak_n);
        row.broken += u64::from(!outcome.broken.is_empty());
        row.wrong += u64::from(outcome.wrong.is_some());
        if let Some(fault) = outcome.fault {
            *row.faults.entry(fault as u8).or_default() += 1;
        }
        if outcome.wrong.is_some() || !outcome.broken.is_empty() {
            row.show([(case.number, case.described(outcome))]);
        }
    }

    /// Adds the results of another table.
    pub fn add(&mut self, other: &Self) {
        self.rows.iter_mut().zip(&other.rows).for_each(|(row, more)| row.add(more));
    }

    /// All kinds of fault, each with its row.
    pub fn kinds(&self) -> impl Iterator<Item = (&'static FaultType, &Row)> {
        FAULTS.iter().zip(&self.rows)
    }

    /// Runs that broke an invariant, plus runs without the required reaction.
    pub fn bad(&self) -> u64 {
        self.rows.iter().map(|r| r.broken + r.wrong).sum()
    }

    /// Descriptions of the recorded bad runs.
    pub fn examples(&self) -> Vec<&str> {
        self.rows.iter().flat_map(|r| &r.examples).map(|(_, text)| text.as_str()).collect()
    }
}

impl Case {
    fn described(&self, outcome: &Outcome) -> String {
        let wrong = outcome.wrong.unwrap_or("the required reaction followed");
        let broken: String = outcome.broken.iter().map(|broken| format!(", broke {} ({})", broken.id, broken.what)).collect();
        let fault = outcome.fault.map_or("no fault".to_owned(), |fault| format!("fault {} ({fault:?})", fault as u8));
        let reaction = outcome.reaction_ticks.map_or("no reaction".to_owned(), |ticks| format!("reaction after {ticks} ticks"));
        format!(
            "{}: {} {} {:?}+{} on the {}: {wrong}{broken}; {fault}, {reaction}",
            self.kind().id,
            self.hand.id,
            self.motion.id,
            self.moment,
            self.after_ticks,
            if self.on_patch { "patch" } else { "wall" },
        )
    }
}

impl Row {
    /// Adds the results of further runs.
    pub fn add(&mut self, more: &Self) {
        self.runs += more.runs;
        self.injected += more.injected;
        self.detected += more.detected;
        for (ticks, count) in &more.reaction_ticks {
            *self.reaction_ticks.entry(*ticks).or_default() += count;
        }
        self.peak_n = self.peak_n.max(more.peak_n);
        self.broken += more.broken;
        self.wrong += more.wrong;
        for (fault, count) in &more.faults {
            *self.faults.entry(*fault).or_default() += count;
        }
        self.show(more.examples.iter().cloned());
    }

    /// Records bad runs and keeps those with the lowest numbers, whatever the order in which they
    /// arrive.
    fn show(&mut self, examples: impl IntoIterator<Item = (u64, String)>) {
        self.examples.extend(examples);
        self.examples.sort();
        self.examples.truncate(SHOWN);
    }

    /// Longest reaction time of any run [ticks].
    pub fn latest_ticks(&self) -> Option<u32> {
        self.reaction_ticks.keys().next_back().copied()
    }

    /// Shortest, median and longest reaction time [ticks]; `None` if the loop reacted in no run.
    pub fn reaction_span_ticks(&self) -> Option<[u32; 3]> {
        let (first, _) = self.reaction_ticks.first_key_value()?;
        let middle = self.reaction_ticks.values().sum::<u64>() / 2;
        let mut below = 0;
        let median = self.reaction_ticks.iter().find(|(_, count)| {
            below += **count;
            below > middle
        });
        Some([*first, *median?.0, self.latest_ticks()?])
    }

    /// Returns the faults in which the runs ended, as pairs `number:count`.
    pub fn ends(&self) -> String {
        let of = |(fault, count): (&u8, &u64)| format!("{fault}:{count}");
        self.faults.iter().map(of).collect::<Vec<_>>().join(" ")
    }
}
