//! Runs of yielding hands, counted by delay and by device.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::{Range, RangeInclusive};

use palpate::BuildError;
use palpate::haptic::cycle::Settings;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::case::{Bounds, YieldingCase};
use super::family::{FAMILY_QUIET_N, FAMILY_WITHIN_J, family};
use super::genes::Genes;
use super::run::{Outcome, RunLength};
use crate::closed_loop::campaign::batches;
use crate::closed_loop::device::{DeviceProfile, PROFILES};
use crate::closed_loop::paths::PathGround;

/// Number of runs that a thread executes at a time.
const BATCH: u64 = 4;
/// Number of the worst runs that are recorded, by each measure.
const SHOWN: usize = 5;
/// Energies above which contacts are counted [J].
const OVER_J: [f64; 3] = [0.01e-3, 0.1e-3, 1e-3];
/// Vibrations above which runs are counted [N].
const SHAKES_N: [f64; 2] = [0.05, 0.1];
/// Largest share of ticks with a lost force, in thousandths, and of contacts above 0.1 mJ where any
/// may be.
const LOST_PER_MILLE: u64 = 1;
const OVER_PER_MILLE: u64 = 1;

/// Groups of delays [ticks], with their name and the least share of the push that is felt (1).
const DELAYS: [(&str, RangeInclusive<u8>, f64); 3] =
    [("delay 0-1", 0..=1, 0.97), ("delay 2-3", 2..=3, 0.8), ("delay 4-7", 4..=7, 0.6)];
/// Name of the family's row.
const FAMILY: &str = "light hands on stiff tissue";

/// Results of some runs. Impulses are integers, so that sums do not depend on their order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HandsRow {
    /// Number of runs.
    pub runs: u64,
    /// Contacts.
    pub contacts: u64,
    /// Contacts that created more than 0.01, 0.1 and 1 mJ.
    pub over: [u64; 3],
    /// Largest energy given since an instant without contact [J].
    pub worst_j: f64,
    /// Largest share of the bound of the run's device (1).
    pub share: f64,
    /// Ticks in which the patch pushed with a force that is felt.
    pub asked_ticks: u64,
    /// Those in which more than half of it was lost for more than 20 ticks.
    pub lost_ticks: u64,
    /// Those among the lost ticks that no flag tells.
    pub unflagged_ticks: u64,
    /// Impulse of the patch's push, and of the force that was sent along it [nN s].
    pub asked_nn_s: i64,
    /// See `asked_nn_s`.
    pub felt_nn_s: i64,
    /// Runs of slow motions with more than 50 and 100 mN above 15 Hz.
    pub shaking: [u64; 2],
    /// Largest vibration [N].
    pub shake_n: f64,
    /// Runs with a fault, by the number of the first one.
    pub faults: BTreeMap<u8, u64>,
}

impl HandsRow {
    fn of(outcome: &Outcome) -> Self {
        let Outcome { given, felt, shake_n, .. } = outcome;
        let nano = |n_s: f64| (n_s * 1e9).round() as i64;
        Self {
            runs: 1,
            contacts: given.contacts_j.len() as u64,
            over: OVER_J.map(|least_j| given.contacts_j.iter().filter(|j| **j > least_j).count() as u64),
            worst_j: given.most_j,
            share: given.share,
            asked_ticks: felt.asked_ticks,
            lost_ticks: felt.lost_ticks,
            unflagged_ticks: felt.unflagged_ticks,
            asked_nn_s: nano(felt.asked_n_s),
            felt_nn_s: nano(felt.felt_n_s),
            shaking: SHAKES_N.map(|least_n| u64::from(*shake_n > least_n)),
            shake_n: *shake_n,
            faults: outcome.fault.map(|fault| BTreeMap::from([(fault as u8, 1)])).unwrap_or_default(),
        }
    }

    fn add(&mut self, other: &Self) {
        self.runs += other.runs;
        self.contacts += other.contacts;
        self.over.iter_mut().zip(other.over).for_each(|(mine, theirs)| *mine += theirs);
        self.worst_j = self.worst_j.max(other.worst_j);
        self.share = self.share.max(other.share);
        self.asked_ticks += other.asked_ticks;
        self.lost_ticks += other.lost_ticks;
        self.unflagged_ticks += other.unflagged_ticks;
        self.asked_nn_s += other.asked_nn_s;
        self.felt_nn_s += other.felt_nn_s;
        self.shaking.iter_mut().zip(other.shaking).for_each(|(mine, theirs)| *mine += theirs);
        self.shake_n = self.shake_n.max(other.shake_n);
        other.faults.iter().for_each(|(fault, runs)| *self.faults.entry(*fault).or_default() += runs);
    }

    /// Share of the patch's push that is felt (1).
    #[must_use]
    pub fn felt(&self) -> f64 {
        if self.asked_nn_s > 0 { self.felt_nn_s as f64 / self.asked_nn_s as f64 } else { 1.0 }
    }

    /// Share of the ticks with a push in which it is lost (1).
    #[must_use]
    pub fn lost(&self) -> f64 {
        self.lost_ticks as f64 / self.asked_ticks.max(1) as f64
    }

    /// The promises that this row breaks, in words. Delays up to three ticks let no contact pass
    /// 0.1 mJ.
    fn broken(&self, name: &str, least_felt: f64, any_over: bool) -> Vec<String> {
        let mut broken = Vec::new();
        let mut unless = |holds: bool, what: String| {
            if !holds {
                broken.push(format!("{name}: {what}"));
            }
        };
        let [_, over, _] = self.over;
        let most_over = if any_over { self.contacts * OVER_PER_MILLE / 1000 } else { 0 };
        unless(over <= most_over, format!("{over} of {} contacts create more than 0.1 mJ", self.contacts));
        unless(self.share <= 1.0, format!("a run gives {:.2} times its bound", self.share));
        unless(
            self.lost_ticks * 1000 <= self.asked_ticks * LOST_PER_MILLE,
            format!("{:.2} % of the force's ticks are lost", self.lost() * 100.0),
        );
        unless(self.unflagged_ticks == 0, format!("{} lost ticks have no flag", self.unflagged_ticks));
        unless(self.felt() >= least_felt, format!("{:.3} of the push is felt, {least_felt} are promised", self.felt()));
        broken
    }
}

/// One of the worst runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Worst {
    /// Number of the run.
    pub number: u64,
    /// By how much it is bad; the unit depends on the measure.
    pub value: f64,
    /// The run in one line.
    pub words: String,
}

/// Rows by delay and by device, and the worst runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HandsTable {
    /// The rows, by name.
    pub rows: BTreeMap<Cow<'static, str>, HandsRow>,
    /// The worst runs by energy [J], share of the bound (1), lost ticks (1) and vibration [N].
    pub worst: BTreeMap<Cow<'static, str>, Vec<Worst>>,
}

impl HandsTable {
    fn count(&mut self, ground: &PathGround, number: u64, name: &'static str, case: &YieldingCase, outcome: &Outcome) {
        self.rows.entry(name.into()).or_default().add(&HandsRow::of(outcome));
        let Outcome { given, felt, shake_n, .. } = outcome;
        let measures =
            [("energy", given.most_j), ("share", given.share), ("lost", felt.lost_ticks as f64), ("shaking", *shake_n)];
        for (measure, value) in measures.into_iter().filter(|(_, value)| *value > 0.0) {
            let felt = felt.felt_n_s / felt.asked_n_s.max(f64::MIN_POSITIVE);
            let words = format!(
                "{name}: {}: {:.4} mJ, {:.3} of the bound, {felt:.2} felt, {} ticks lost, {:.0} mN, {} faults {}",
                case.in_words(ground),
                given.most_j * 1e3,
                given.share,
                outcome.felt.lost_ticks,
                shake_n * 1e3,
                outcome.faults,
                outcome.fault.map_or(String::new(), |fault| fault.to_string())
            );
            self.record(measure.into(), [Worst { number, value, words }]);
        }
    }

    fn record(&mut self, measure: Cow<'static, str>, runs: impl IntoIterator<Item = Worst>) {
        let worst = self.worst.entry(measure).or_default();
        worst.extend(runs);
        worst.sort_by(|a, b| b.value.total_cmp(&a.value).then(a.number.cmp(&b.number)));
        worst.truncate(SHOWN);
    }

    /// Adds the results of another table.
    pub fn add(&mut self, other: Self) {
        other.rows.into_iter().for_each(|(name, row)| self.rows.entry(name).or_default().add(&row));
        other.worst.into_iter().for_each(|(measure, runs)| self.record(measure, runs));
    }

    /// Every promise that does not hold, in words.
    #[must_use]
    pub fn broken(&self) -> Vec<String> {
        let mut broken = Vec::new();
        for (name, row) in &self.rows {
            if name == FAMILY {
                if row.shake_n > FAMILY_QUIET_N {
                    broken.push(format!("{name}: the force swings by {:.2} N RMS", row.shake_n));
                }
                if row.worst_j > FAMILY_WITHIN_J {
                    broken.push(format!("{name}: {:.2} mJ in a press", row.worst_j * 1e3));
                }
                continue;
            }
            let group = DELAYS.iter().find(|(group, ..)| group == name);
            // every shipped device has a delay of one tick
            let least_felt = group.or(DELAYS.first()).map_or(0.0, |(_, _, felt)| *felt);
            broken.extend(row.broken(name, least_felt, group.is_some_and(|(_, delays, _)| *delays.start() > 3)));
        }
        broken
    }
}

/// A campaign of yielding hands.
#[derive(Clone, Debug)]
pub struct Hands<'a> {
    ground: &'a PathGround,
    base: &'a DeviceProfile,
    runs: u64,
    seed: u64,
    length: RunLength,
    family: Vec<YieldingCase>,
}

impl<'a> Hands<'a> {
    /// This many random runs, every second one on a shipped device, and the family of light hands
    /// on stiff tissue; with `quick` shorter runs and an eighth of the family.
    #[must_use]
    pub fn new(ground: &'a PathGround, runs: u64, seed: u64, quick: bool) -> Self {
        let base = &ground.devices[0];
        let (length, share) = if quick { (RunLength::QUICK, 8) } else { (RunLength::FULL, 1) };
        Self { ground, base, runs, seed, length, family: family(ground, base, share) }
    }

    /// The same campaign with runs of this length.
    #[must_use]
    pub fn lasting(self, length: RunLength) -> Self {
        Self { length, ..self }
    }

    /// Number of cases: the random runs, and then the family.
    #[must_use]
    pub fn cases(&self) -> u64 {
        self.runs + self.family.len() as u64
    }

    /// Name of the row and the case with this number.
    #[must_use]
    pub fn case(&self, number: u64) -> (&'static str, YieldingCase) {
        if let Some(case) = number.checked_sub(self.runs).and_then(|n| self.family.get(n as usize)) {
            return (FAMILY, case.clone());
        }
        let genes = Genes::draw(number, self.seed);
        if number % 2 == 1 {
            let device = (number / 2) as usize % PROFILES.len();
            let name = PROFILES[device].0;
            return (name, YieldingCase::on_device(self.ground, &genes, &self.ground.devices[device], name));
        }
        let case = YieldingCase::of(self.ground, &genes, self.base, Bounds::Person);
        let group = DELAYS.iter().find(|(_, delays, _)| delays.contains(&case.device.delay_ticks));
        (group.map_or("", |(name, ..)| *name), case)
    }

    /// Runs the cases with these numbers; `change` may change the loop's settings, `done` is called
    /// after every batch. The tables of parts of a range add up to the table of the whole range.
    ///
    /// # Errors
    /// The loop or a patch refuses its settings.
    pub fn run(
        &self,
        cases: Range<u64>,
        change: impl Fn(&mut Settings) + Sync,
        done: impl Fn(u64) + Sync,
    ) -> Result<HandsTable, BuildError> {
        let part = |numbers: Range<u64>| {
            let mut table = HandsTable::default();
            for number in numbers.clone() {
                let (name, case) = self.case(number);
                let length =
                    if name == FAMILY { RunLength { motion_s: RunLength::FULL.motion_s, ..self.length } } else { self.length };
                table.count(self.ground, number, name, &case, &case.run(self.ground, length, &change)?);
            }
            done(numbers.end - numbers.start);
            Ok(table)
        };
        batches(cases, BATCH).map(part).try_reduce(HandsTable::default, |mut table, more| {
            table.add(more);
            Ok(table)
        })
    }
}
