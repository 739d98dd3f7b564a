//! Results of some runs of yielding hands, and what they must be.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::run::Outcome;

/// Energies above which contacts are counted [J].
const OVER_J: [f64; 3] = [0.01e-3, 0.1e-3, 1e-3];
/// Vibrations above which runs are counted [N].
const SHAKES_N: [f64; 2] = [0.05, 0.1];
/// Largest share of ticks with a force lost by a hand that owes nothing, in thousandths, and of
/// contacts above 0.1 mJ where any may be.
const LOST_PER_MILLE: u64 = 1;
const OVER_PER_MILLE: u64 = 1;

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
    /// Those among the lost ticks in which the hand owed more than 0.1 mJ that it had been given.
    pub owed_ticks: u64,
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
    pub(super) fn of(outcome: &Outcome) -> Self {
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
            owed_ticks: felt.owed_ticks,
            unflagged_ticks: felt.unflagged_ticks,
            asked_nn_s: nano(felt.asked_n_s),
            felt_nn_s: nano(felt.felt_n_s),
            shaking: SHAKES_N.map(|least_n| u64::from(*shake_n > least_n)),
            shake_n: *shake_n,
            faults: outcome.fault.map(|fault| BTreeMap::from([(fault as u8, 1)])).unwrap_or_default(),
        }
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.runs += other.runs;
        self.contacts += other.contacts;
        self.over.iter_mut().zip(other.over).for_each(|(mine, theirs)| *mine += theirs);
        self.worst_j = self.worst_j.max(other.worst_j);
        self.share = self.share.max(other.share);
        self.asked_ticks += other.asked_ticks;
        self.lost_ticks += other.lost_ticks;
        self.owed_ticks += other.owed_ticks;
        self.unflagged_ticks += other.unflagged_ticks;
        self.asked_nn_s += other.asked_nn_s;
        self.felt_nn_s += other.felt_nn_s;
        self.shaking.iter_mut().zip(other.shaking).for_each(|(mine, theirs)| *mine += theirs);
        self.shake_n = self.shake_n.max(other.shake_n);
        other.faults.iter().for_each(|(fault, runs)| *self.faults.entry(*fault).or_default() += runs);
    }

    /// Share of the patch's push that is felt (1).
    pub fn felt(&self) -> f64 {
        if self.asked_nn_s > 0 { self.felt_nn_s as f64 / self.asked_nn_s as f64 } else { 1.0 }
    }

    /// Share of the ticks with a push in which it is lost (1).
    pub fn lost(&self) -> f64 {
        self.lost_ticks as f64 / self.asked_ticks.max(1) as f64
    }

    /// Share of the ticks with a push in which a hand that owes nothing loses it (1).
    pub fn lost_unowed(&self) -> f64 {
        self.unowed_ticks() as f64 / self.asked_ticks.max(1) as f64
    }

    fn unowed_ticks(&self) -> u64 {
        self.lost_ticks - self.owed_ticks
    }

    /// The promises that this row breaks, in words. Delays up to three ticks let no contact pass
    /// 0.1 mJ.
    pub(super) fn broken(&self, name: &str, least_felt: f64, any_over: bool) -> Vec<String> {
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
            self.unowed_ticks() * 1000 <= self.asked_ticks * LOST_PER_MILLE,
            format!("{:.2} % of the force's ticks are lost by hands that owe nothing", self.lost_unowed() * 100.0),
        );
        unless(self.unflagged_ticks == 0, format!("{} lost ticks have no flag", self.unflagged_ticks));
        unless(self.felt() >= least_felt, format!("{:.3} of the push is felt, {least_felt} are promised", self.felt()));
        broken
    }
}
