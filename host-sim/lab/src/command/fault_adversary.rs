//! The command `palpate faults --adversary`.

use std::path::Path;

use crate::faults::paths::PathGround;
use crate::faults::yielding::{Adversary, Aim, Bounds, GENES, Genes, Outcome, RunLength, YieldingCase};
use palpate::BuildError;
use palpate::haptic::account::AccountSettings;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;
use serde::Serialize;

use palpate_sim::command::options::faults::RUN_DIGITS;
use palpate_sim::command::progress::Progress;
use palpate_sim::command::verdict::Verdict;
use palpate_sim::error::Error;
use palpate_sim::provenance;

/// Rounds of a search, and with `--quick`.
pub(super) const ROUNDS: u64 = 60;
pub(super) const QUICK_ROUNDS: u64 = 4;

// the command line counts the digits before the evidence is built
const _: () = assert!(RUN_DIGITS == 4 * GENES);

/// Genes of a run, and what its hand may do.
#[derive(Clone, Copy, Debug)]
struct NamedRun(Bounds, Genes);

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

/// Contents of `summary.json`.
#[derive(Serialize)]
struct Summary {
    seed: u64,
    rounds: u64,
    runs: u64,
    worst: Vec<WorstRun>,
}

/// The worst run of a search.
#[derive(Serialize)]
struct WorstRun {
    searched_for: &'static str,
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

impl WorstRun {
    fn of(ground: &PathGround, searched_for: &'static str, named: NamedRun, outcome: &Outcome) -> Self {
        let case = YieldingCase::of(ground, &named.1, &ground.devices[0], named.0);
        let bound = case.bound(&AccountSettings::DEFAULT);
        Self {
            searched_for,
            share_of_bound: outcome.given.share,
            given_mj: outcome.given.most_j * 1e3,
            created_in_a_contact_mj: Aim::Created.value(outcome).max(0.0) * 1e3,
            vibration_mn: outcome.shake_n * 1e3,
            at_once_mj: f64::from(bound.at_once_j) * 1e3,
            in_ten_seconds_mj: f64::from(bound.within_j(10.0)) * 1e3,
            hand_m_per_s2: outcome.hand_m_per_s2,
            faults: outcome.faults,
            genes: named.to_string(),
            case: case.in_words(ground),
        }
    }

    fn print(&self) {
        println!(
            "{}: {:.4} of the bound ({:.3} mJ at once, {:.3} mJ in ten seconds), {:.4} mJ given, {:.4} mJ in a contact, {:.0} mN, hand {:.0} m/s^2, {} faults",
            self.searched_for,
            self.share_of_bound,
            self.at_once_mj,
            self.in_ten_seconds_mj,
            self.given_mj,
            self.created_in_a_contact_mj,
            self.vibration_mn,
            self.hand_m_per_s2,
            self.faults
        );
        println!("  {}\n  again: palpate faults --adversary --genes {}", self.case, self.genes);
    }
}

/// Searches for the worst runs, or runs these genes again.
pub(super) fn search(out: &Path, seed: u64, rounds: u64, again: Option<&str>) -> Result<(), Error> {
    let folder = OutputFolder::open(out)?.made_by(provenance::of(None));
    let ground = PathGround::load()?;
    let adversary = Adversary { ground: &ground, seed, length: RunLength::FULL };
    let run = |searched_for, named: NamedRun| -> Result<WorstRun, BuildError> {
        Ok(WorstRun::of(&ground, searched_for, named, &adversary.try_genes(&named.1, named.0, &|_| ())?))
    };
    let (mut worst, mut runs) = (Vec::new(), 0);
    if let Some(text) = again {
        let named = text.parse().map_err(|e| Error::from(TissueError::Usage(e)))?;
        worst.push(run("this run", named)?);
        runs += 1;
    } else {
        let progress = Progress::new(Adversary::runs(rounds) * Aim::ALL.len() as u64, "runs");
        for (aim, searched_for) in Aim::ALL.into_iter().zip(["share of the bound", "energy of a contact", "vibration"]) {
            let found = adversary.search(aim, rounds, |_| (), |n| progress.inc(n))?;
            worst.push(run(searched_for, NamedRun(aim.bounds(), found.genes))?);
            runs += found.runs;
        }
        progress.finish();
    }
    let most = worst.iter().map(|run| run.share_of_bound).fold(0.0, f64::max);
    // written so that NaN fails
    let judged = if most <= 1.0 {
        Ok(())
    } else {
        Err(Error::from(TissueError::Check(format!("a hand was given {most:.3} times the bound of its device"))))
    };
    let verdict = Verdict::of(judged, || format!("the worst of {runs} runs gives {most:.4} of its bound"))?.first();
    worst.iter().for_each(WorstRun::print);
    folder.write_summary(&Summary { seed, rounds, runs, worst })?;
    println!("wrote {}: summary.json", folder.publish()?.display());
    verdict.last()
}
