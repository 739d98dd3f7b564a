//! The command `palpate faults --adversary`.

use std::ops::Range;

use crate::faults::paths::PathGround;
use crate::faults::yielding::{Adversary, Aim, Bounds, GENES, Genes, Outcome, RunLength, YieldingCase};
use palpate::BuildError;
use palpate::haptic::account::AccountSettings;
use palpate_sim::command::options::faults::RUN_DIGITS;
use palpate_sim::command::progress::Progress;
use palpate_sim::error::Error;
use serde::{Deserialize, Serialize};

use crate::study::{Claim, Findings, Study, Table};

/// Rounds of a search, and with `--quick`.
pub(super) const ROUNDS: u64 = 60;
pub(super) const QUICK_ROUNDS: u64 = 4;
/// Quantities that are searched for, in the order of [`Aim::ALL`].
const SEARCHED_FOR: [&str; 3] = ["share of the bound", "energy of a contact", "vibration"];

// the command line counts the digits before the evidence is built
const _: () = assert!(RUN_DIGITS == 4 * GENES);

/// Genes of a run, and what its hand may do.
#[derive(Clone, Copy, Debug)]
pub(super) struct NamedRun(Bounds, Genes);

impl std::str::FromStr for NamedRun {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (bounds, genes) = text.split_once(':').unwrap_or(("", text));
        Ok(Self(if bounds == "person" { Bounds::Person } else { Bounds::Hand }, genes.parse()?))
    }
}

impl std::fmt::Display for NamedRun {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let bounds = if self.0 == Bounds::Person { "person" } else { "hand" };
        write!(f, "{bounds}:{}", self.1)
    }
}

/// A search for each aim, or one run.
pub(super) struct Search {
    seed: u64,
    rounds: u64,
    /// A run to be made again, instead of a search.
    again: Option<NamedRun>,
    ground: PathGround,
}

/// The worst run of a search.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct WorstRun {
    searched_for: String,
    runs: u64,
    share_of_bound: f64,
    given_mj: f64,
    created_in_a_contact_mj: f64,
    vibration_mn: f64,
    at_once_mj: f64,
    in_ten_seconds_mj: f64,
    hand_m_per_s2: f64,
    faults: u32,
    genes: String,
    case: String,
}

impl Search {
    pub(super) fn of(seed: u64, rounds: u64, again: Option<NamedRun>) -> Result<Self, Error> {
        Ok(Self { seed, rounds, again, ground: PathGround::load()? })
    }

    fn worst(&self, searched_for: &str, runs: u64, named: NamedRun, outcome: &Outcome) -> WorstRun {
        let case = YieldingCase::of(&self.ground, &named.1, &self.ground.devices[0], named.0);
        let bound = case.bound(&AccountSettings::DEFAULT);
        WorstRun {
            searched_for: searched_for.to_owned(),
            runs,
            share_of_bound: outcome.given.share,
            given_mj: outcome.given.most_j * 1e3,
            created_in_a_contact_mj: Aim::Created.value(outcome).max(0.0) * 1e3,
            vibration_mn: outcome.shake_n * 1e3,
            at_once_mj: f64::from(bound.at_once_j) * 1e3,
            in_ten_seconds_mj: f64::from(bound.within_j(10.0)) * 1e3,
            hand_m_per_s2: outcome.hand_m_per_s2,
            faults: outcome.faults,
            genes: named.to_string(),
            case: case.in_words(&self.ground),
        }
    }
}

impl Study for Search {
    type Row = WorstRun;

    fn cases(&self) -> u64 {
        if self.again.is_some() { 1 } else { Aim::ALL.len() as u64 }
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, WorstRun)>, Error> {
        let adversary = Adversary { ground: &self.ground, seed: self.seed, length: RunLength::FULL };
        let run = |searched_for, runs, named: NamedRun| -> Result<WorstRun, BuildError> {
            Ok(self.worst(searched_for, runs, named, &adversary.try_genes(&named.1, named.0, &|_| ())?))
        };
        if let Some(named) = self.again {
            return Ok(vec![(0, run("this run", 1, named)?)]);
        }
        let progress = Progress::new(Adversary::runs(self.rounds) * (cases.end - cases.start), "runs");
        let search = |n: u64| -> Result<(u64, WorstRun), BuildError> {
            let aim = Aim::ALL[n as usize];
            let found = adversary.search(aim, self.rounds, |_| (), |n| progress.inc(n))?;
            Ok((n, run(SEARCHED_FOR[n as usize], found.runs, NamedRun(aim.bounds(), found.genes))?))
        };
        let worst = cases.map(search).collect::<Result<_, _>>()?;
        progress.finish();
        Ok(worst)
    }

    fn findings(&self, worst: Vec<WorstRun>) -> Result<Findings, Error> {
        let most = worst.iter().map(|run| run.share_of_bound).fold(0.0, f64::max);
        let again = |run: &WorstRun| format!("{}\n  again: palpate faults --adversary --genes {}", run.case, run.genes);
        let mut findings = Findings {
            // written so that NaN fails
            claims: vec![Claim::promise(
                "share of the bound of its device that a hand is given",
                "at most 1",
                format!("{most:.4} in the worst of {} runs", worst.iter().map(|run| run.runs).sum::<u64>()),
                most <= 1.0,
            )],
            tables: vec![Table::of("adversary", &worst)?.columns(&[
                "searched_for",
                "share_of_bound",
                "at_once_mj",
                "in_ten_seconds_mj",
                "given_mj",
                "created_in_a_contact_mj",
                "vibration_mn",
                "hand_m_per_s2",
                "faults",
            ])],
            notes: worst.iter().map(again).collect(),
            ..Findings::default()
        };
        findings.fact("seed", self.seed);
        findings.fact("rounds", self.rounds);
        Ok(findings)
    }
}
