//! The runs of a path campaign, counted by kind of path and by patch.

use std::borrow::Cow;
use std::collections::BTreeMap;

use palpate::Fault;
use serde::{Deserialize, Serialize};

use super::case::{KINDS, PathCase};
use super::ground::PathGround;
use super::run::PathOutcome;

/// Number of bad runs that are recorded.
const SHOWN: usize = 40;
/// Energy that a contact may create [J].
pub const CREATED_J: f64 = 0.01e-3;

/// Results for one kind of path.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PathRow {
    /// Number of runs.
    pub runs: u64,
    /// Ticks along the paths.
    pub ticks: u64,
    /// Ticks with a force.
    pub ticks_with_force: u64,
    /// Largest distance of the sensed tip from the tissue with a force [m].
    pub outside_m: f64,
    /// Longest run of ticks with a force and the tip more than 1 mm outside.
    pub outside_ticks: u32,
    /// Largest force into the tissue [N].
    pub into_n: f64,
    /// Largest number of consecutive reversals of a force that oscillated while the tip was at
    /// rest.
    pub chatter_turns: u32,
    /// Runs that broke an invariant, by its id.
    pub broken: BTreeMap<Cow<'static, str>, u64>,
    /// Runs ended by a fault, by the number of the fault.
    pub faults: BTreeMap<u8, u64>,
    /// Runs ended by a fault during motion that a hand can make, by the number of the fault.
    pub honest_faults: BTreeMap<u8, u64>,
    /// Energy created by the worst contact [J].
    pub created_j: f64,
    /// Runs in which a contact created more energy than is allowed.
    pub creating: u64,
    /// Runs with motion that a hand can make.
    pub by_hand: u64,
    /// Energy created by the worst contact of the runs with such motion [J].
    pub created_by_hand_j: f64,
    /// Runs with such motion in which a contact created more energy than is allowed.
    pub creating_by_hand: u64,
    /// Largest force [N].
    pub peak_n: f32,
}

/// Runs on one patch under one tip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PatchRow {
    /// Number of runs.
    pub runs: u64,
    /// Runs with motion that a hand can make.
    pub by_hand: u64,
    /// Runs with such motion in which a contact created more energy than is allowed.
    pub creating_by_hand: u64,
}

impl PatchRow {
    fn add(&mut self, other: &Self) {
        self.runs += other.runs;
        self.by_hand += other.by_hand;
        self.creating_by_hand += other.creating_by_hand;
    }
}

/// One row for each kind of path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathTable {
    /// The rows, in the order of [`KINDS`].
    pub rows: Vec<PathRow>,
    /// Runs on each patch and tip.
    pub patches: BTreeMap<Cow<'static, str>, PatchRow>,
    /// The first runs that broke an invariant or ended motion that a hand can make, as text.
    pub examples: Vec<String>,
    /// The first runs with motion that a hand can make, in which a contact created more energy than
    /// is allowed, as text.
    pub creating: Vec<String>,
}

impl Default for PathTable {
    fn default() -> Self {
        let rows = vec![PathRow::default(); KINDS.len()];
        Self { rows, patches: BTreeMap::new(), examples: Vec::new(), creating: Vec::new() }
    }
}

impl PathRow {
    fn add(&mut self, other: &Self) {
        self.runs += other.runs;
        self.ticks += other.ticks;
        self.ticks_with_force += other.ticks_with_force;
        self.outside_m = self.outside_m.max(other.outside_m);
        self.outside_ticks = self.outside_ticks.max(other.outside_ticks);
        self.into_n = self.into_n.max(other.into_n);
        self.chatter_turns = self.chatter_turns.max(other.chatter_turns);
        self.created_j = self.created_j.max(other.created_j);
        self.creating += other.creating;
        self.by_hand += other.by_hand;
        self.created_by_hand_j = self.created_by_hand_j.max(other.created_by_hand_j);
        self.creating_by_hand += other.creating_by_hand;
        self.peak_n = self.peak_n.max(other.peak_n);
        for (mine, theirs) in [(&mut self.faults, &other.faults), (&mut self.honest_faults, &other.honest_faults)] {
            theirs.iter().for_each(|(fault, count)| *mine.entry(*fault).or_default() += count);
        }
        other.broken.iter().for_each(|(id, count)| *self.broken.entry(id.clone()).or_default() += count);
    }

    /// Runs that broke an invariant, counted once for each invariant.
    pub fn broke(&self) -> u64 {
        self.broken.values().sum()
    }
}

impl PathTable {
    /// Counts one run.
    pub fn count(&mut self, ground: &PathGround, case: &PathCase, outcome: &PathOutcome) {
        let seen = &outcome.seen;
        let mut row = PathRow {
            runs: 1,
            ticks: outcome.ticks,
            ticks_with_force: seen.ticks_with_force,
            outside_m: seen.outside_m,
            outside_ticks: seen.outside_ticks,
            into_n: seen.into_n,
            chatter_turns: seen.chatter_turns,
            created_j: outcome.created_j,
            creating: u64::from(outcome.created_j > CREATED_J),
            by_hand: u64::from(outcome.by_hand),
            created_by_hand_j: if outcome.by_hand { outcome.created_j } else { 0.0 },
            creating_by_hand: u64::from(outcome.by_hand && outcome.created_j > CREATED_J),
            peak_n: outcome.peak_n,
            ..PathRow::default()
        };
        for (broken, _) in &outcome.broken {
            row.broken.insert(broken.id.into(), 1);
        }
        let number = |fault: Fault| BTreeMap::from([(fault as u8, 1)]);
        row.faults = outcome.fault.map(number).unwrap_or_default();
        row.honest_faults = outcome.fault.filter(|_| outcome.honest).map(number).unwrap_or_default();
        let bad = !outcome.broken.is_empty() || !row.honest_faults.is_empty();
        for (examples, shows) in [(&mut self.examples, bad), (&mut self.creating, row.creating_by_hand > 0)] {
            if shows && examples.len() < SHOWN {
                examples.push(case.telemetry(ground, outcome));
            }
        }
        let here = PatchRow { runs: 1, by_hand: row.by_hand, creating_by_hand: row.creating_by_hand };
        self.patches.entry(ground.patches[case.patch].label()).or_default().add(&here);
        if let Some(mine) = self.rows.get_mut(case.kind) {
            mine.add(&row);
        }
    }

    /// Adds the results of another table.
    pub fn add(&mut self, other: &Self) {
        self.rows.iter_mut().zip(&other.rows).for_each(|(mine, theirs)| mine.add(theirs));
        other.patches.iter().for_each(|(label, row)| self.patches.entry(label.clone()).or_default().add(row));
        for (mine, theirs) in [(&mut self.examples, &other.examples), (&mut self.creating, &other.creating)] {
            mine.extend(theirs.iter().cloned());
            mine.truncate(SHOWN);
        }
    }

    /// Results of all kinds of path together.
    pub fn total(&self) -> PathRow {
        let mut total = PathRow::default();
        self.rows.iter().for_each(|row| total.add(row));
        total
    }
}

impl PathCase {
    /// The run in one line: its description and its violations.
    pub fn telemetry(&self, ground: &PathGround, outcome: &PathOutcome) -> String {
        format!(
            "path {} of seed {}: {}, {}, {:.1} kPa, {}{}: {:?}, fault {:?}{}, {:.1} mm outside, {} ticks, chatter {}, into {:.3} N, peak {:.2} N, created {:.4} mJ",
            self.number,
            self.seed,
            KINDS[self.kind].1,
            ground.patches[self.patch].label(),
            self.youngs_modulus_pa * 1e-3,
            ground.devices[self.device].name,
            if self.guarded { ", guarded" } else { "" },
            outcome.broken,
            outcome.fault,
            if outcome.honest { " (honest)" } else { "" },
            outcome.seen.outside_m * 1e3,
            outcome.seen.outside_ticks,
            outcome.seen.chatter_turns,
            outcome.seen.into_n,
            outcome.peak_n,
            outcome.created_j * 1e3
        )
    }
}
