//! A search for the worst run: climbers mutate the genes of a run and keep what is worse.

use palpate::BuildError;
use palpate::haptic::cycle::Settings;
use rayon::prelude::*;

use super::case::{Bounds, YieldingCase};
use super::genes::Genes;
use super::run::{Outcome, RunLength};
use crate::faults::paths::PathGround;

/// Number of climbers, and of neighbours that each tries in a round.
const CLIMBERS: u64 = 4;
const NEIGHBOURS: u64 = 4;
/// Random draws from which a climber takes the worst to start.
const DRAWS: u64 = 8;
/// Rounds without progress after which a climber starts anew.
const PATIENCE: u32 = 6;
/// Numbers of draws per round; a restart uses numbers of its own.
const PER_ROUND: u64 = CLIMBERS * (NEIGHBOURS + DRAWS);
/// Largest acceleration of a hand [m/s^2]: a run in which the hand goes beyond it does not count.
const HAND_M_PER_S2: f64 = 200.0;

/// Quantity that is searched for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// The largest share of the bound.
    Share,
    /// The contact that creates most energy.
    Created,
    /// The strongest vibration under what a person does.
    Shaking,
}

impl Aim {
    /// Every aim.
    pub const ALL: [Self; 3] = [Self::Share, Self::Created, Self::Shaking];

    /// Behaviour that a hand may show in this search.
    pub fn bounds(self) -> Bounds {
        if self == Self::Shaking { Bounds::Person } else { Bounds::Hand }
    }

    /// How bad a run is; the unit is 1, J or N.
    pub fn value(self, outcome: &Outcome) -> f64 {
        let created_j = outcome.given.contacts_j.iter().copied().fold(0.0, f64::max);
        match self {
            _ if outcome.hand_m_per_s2 > HAND_M_PER_S2 => -1.0,
            Self::Share => outcome.given.share,
            Self::Created => created_j,
            Self::Shaking => outcome.shake_n,
        }
    }
}

/// The worst run of a search.
#[derive(Clone, Debug)]
pub struct Found {
    /// Genes of the run.
    pub genes: Genes,
    /// How bad it is, in the unit of the aim.
    pub value: f64,
    /// Number of runs that were tried.
    pub runs: u64,
}

impl Found {
    /// Takes the worst of some more runs.
    fn take(&mut self, genes: Genes, value: f64, runs: u64) {
        self.runs += runs;
        if value > self.value {
            (self.genes, self.value) = (genes, value);
        }
    }
}

/// A search on a ground.
#[derive(Clone, Copy, Debug)]
pub struct Adversary<'a> {
    /// Patches and devices.
    pub ground: &'a PathGround,
    /// Seed of the draws.
    pub seed: u64,
    /// Length of a run.
    pub length: RunLength,
}

struct Climber {
    genes: Genes,
    value: f64,
    stale: u32,
}

impl Adversary<'_> {
    /// Number of runs that a search of this many rounds takes if no climber starts anew.
    pub fn runs(rounds: u64) -> u64 {
        CLIMBERS * (DRAWS + rounds * NEIGHBOURS)
    }

    /// Runs these genes.
    pub fn try_genes(
        &self,
        genes: &Genes,
        bounds: Bounds,
        change: &(impl Fn(&mut Settings) + Sync),
    ) -> Result<Outcome, BuildError> {
        YieldingCase::of(self.ground, genes, &self.ground.devices[0], bounds).run(self.ground, self.length, change)
    }

    /// Climbs for this many rounds; `done` is called with the number of runs after every round.
    pub fn search(
        &self,
        aim: Aim,
        rounds: u64,
        change: impl Fn(&mut Settings) + Sync,
        done: impl Fn(u64),
    ) -> Result<Found, BuildError> {
        let value = |genes: Genes| Ok((genes, aim.value(&self.try_genes(&genes, aim.bounds(), &change)?)));
        let worst_of = |genes: Vec<Genes>| -> Result<(Genes, f64), BuildError> {
            let tried: Result<Vec<(Genes, f64)>, BuildError> = genes.into_par_iter().map(value).collect();
            Ok(tried?
                .into_iter()
                .fold((Genes::MIDDLE, f64::NEG_INFINITY), |worst, next| if next.1 > worst.1 { next } else { worst }))
        };
        let started = |from: u64| worst_of((from..from + DRAWS).map(|number| Genes::draw(number, self.seed)).collect());
        let mut found = Found { genes: Genes::MIDDLE, value: f64::NEG_INFINITY, runs: 0 };
        let mut climbers = Vec::new();
        for climber in 0..CLIMBERS {
            let (genes, value) = started(climber * DRAWS)?;
            climbers.push(Climber { genes, value, stale: 0 });
            found.take(genes, value, DRAWS);
            done(DRAWS);
        }
        for round in 1..=rounds {
            for (number, climber) in (0..CLIMBERS).zip(&mut climbers) {
                let first = round * PER_ROUND + number * (NEIGHBOURS + DRAWS);
                if climber.stale >= PATIENCE {
                    let (genes, value) = started(first + NEIGHBOURS)?;
                    *climber = Climber { genes, value, stale: 0 };
                    found.take(genes, value, DRAWS);
                }
                let near = (first..first + NEIGHBOURS).map(|number| climber.genes.mutated(number, self.seed)).collect();
                let (genes, value) = worst_of(near)?;
                found.take(genes, value, NEIGHBOURS);
                climber.stale += 1;
                if value > climber.value {
                    *climber = Climber { genes, value, stale: 0 };
                }
                done(NEIGHBOURS);
            }
        }
        Ok(found)
    }
}
