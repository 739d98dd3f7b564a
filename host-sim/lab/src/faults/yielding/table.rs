//! Rows of yielding hands by lateness and by device, and the worst runs.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::case::YieldingCase;
use super::family::{FAMILY_QUIET_N, FAMILY_WITHIN_J};
use super::row::HandsRow;
use super::run::Outcome;
use crate::faults::paths::PathGround;

/// Number of the worst runs that are recorded, by each measure.
const SHOWN: usize = 5;

/// Groups of random devices by the time until half of a force acts, delay and amplifier's lag
/// together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lateness {
    pub name: &'static str,
    /// Longest such time [s].
    pub most_s: f64,
    /// Least share of the push that is felt (1).
    least_felt: f64,
    /// Whether one contact in a thousand may pass 0.1 mJ.
    any_over: bool,
}

pub(super) const LATENESSES: [Lateness; 4] = [
    Lateness { name: "late to 1.5 ms", most_s: 1.5e-3, least_felt: 0.97, any_over: false },
    Lateness { name: "late to 3.5 ms", most_s: 3.5e-3, least_felt: 0.97, any_over: false },
    Lateness { name: "late to 5.5 ms", most_s: 5.5e-3, least_felt: 0.97, any_over: false },
    Lateness { name: "later", most_s: f64::INFINITY, least_felt: 0.6, any_over: true },
];
/// Name of the family's row.
pub(super) const FAMILY: &str = "light hands on stiff tissue";
/// Name of the row of long runs.
pub(super) const MINUTES: &str = "a minute of each motion";

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

/// Rows by lateness and by device, and the worst runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HandsTable {
    /// The rows, by name.
    pub rows: BTreeMap<Cow<'static, str>, HandsRow>,
    /// The worst runs by energy [J], share of the bound (1), lost ticks (1) and vibration [N].
    pub worst: BTreeMap<Cow<'static, str>, Vec<Worst>>,
}

impl HandsTable {
    pub(super) fn count(&mut self, ground: &PathGround, number: u64, name: &'static str, case: &YieldingCase, outcome: &Outcome) {
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
            // a shipped device is promised what the first group is
            let [first, ..] = LATENESSES;
            let group = LATENESSES.into_iter().find(|group| group.name == name).unwrap_or(first);
            // a press that is held at the force limit is relieved, which takes some of the force of
            // a minute; what is judged there is that none is lost
            let least_felt = if name == MINUTES { 0.0 } else { group.least_felt };
            broken.extend(row.broken(name, least_felt, group.any_over));
        }
        broken
    }
}
