//! The annealing schedule of paper 004 (sections 2.2 and 3.4), and a random walk that follows it
//! with proposals, Metropolis's criterion and cooling.
//!
//! The paper gives neither the reach of a trial nor the unit of the objective. Here the reach
//! adapts to the share of accepted trials, and every objective states its unit. The state of a walk
//! consists of plain numbers, so that a walk that is stored and read back continues where it
//! stopped.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

/// Temperatures of an annealing, from hot to cold.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Schedule {
    /// First temperature, in units of the cost.
    pub first: f64,
    /// Last temperature, in units of the cost.
    pub last: f64,
    /// Ratio of each temperature to the previous one (1).
    pub cooling: f64,
    /// Number of trials at each temperature.
    pub trials: usize,
}

/// Smallest and largest reach of a trial, in the unit of the coordinates.
const REACH: [f64; 2] = [1e-4, 1.0];
/// Share of accepted trials at which the reach remains constant, and the rate of its adaptation
/// (1).
const TAKEN: f64 = 0.44;
const FOLLOWS: f64 = 0.2;

impl Schedule {
    /// Schedule of the paper: 570 temperatures, 114 000 trials.
    pub const PAPER: Self = Self { first: 100.0, last: 0.001, cooling: 0.98, trials: 200 };

    /// Number of temperatures.
    pub const fn temperatures(&self) -> usize {
        let (mut temperature, mut count) = (self.first, 0);
        while temperature > self.last {
            temperature *= self.cooling;
            count += 1;
        }
        count
    }

    /// Number of trials of the whole schedule.
    pub const fn length(&self) -> usize {
        self.temperatures() * self.trials
    }

    /// Temperature of a trial if `trials` trials are spread over all temperatures.
    pub fn temperature(&self, trial: usize, trials: usize) -> f64 {
        self.first * self.cooling.powi((trial * self.temperatures() / trials) as i32)
    }
}

/// Outcome of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The trial was rejected, and the walk stays at its place.
    Refused,
    /// The walk moved to the trial.
    Taken,
    /// The walk moved to the trial, whose cost is the lowest so far.
    Best,
}

/// State of a walk.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Walk {
    schedule: Schedule,
    seed: u64,
    trials: usize,
    trial: usize,
    reach: f64,
    place: Vec<f64>,
    cost: f64,
    best: (Vec<f64>, f64),
}

impl Walk {
    /// A walk of `trials` trials that starts at `place` with the cost `cost`.
    pub fn start(schedule: Schedule, trials: usize, seed: u64, place: Vec<f64>, cost: f64) -> Self {
        Self { schedule, seed, trials, trial: 0, reach: REACH[1], best: (place.clone(), cost), place, cost }
    }

    /// Number of trials so far, and total number.
    pub fn trials(&self) -> (usize, usize) {
        (self.trial, self.trials)
    }

    /// Whether the schedule is complete.
    pub fn is_done(&self) -> bool {
        self.trial >= self.trials
    }

    /// Temperature of the next trial, in units of the cost.
    pub fn temperature(&self) -> f64 {
        self.schedule.temperature(self.trial, self.trials)
    }

    /// Present place of the walk and its cost.
    pub fn here(&self) -> (&[f64], f64) {
        (&self.place, self.cost)
    }

    /// Best place so far and its cost.
    pub fn best(&self) -> (&[f64], f64) {
        (&self.best.0, self.best.1)
    }

    /// Whether two walks have the same schedule, seed and number of trials, regardless of their
    /// progress.
    pub fn is_same(&self, other: &Self) -> bool {
        (self.schedule, self.seed, self.trials) == (other.schedule, other.seed, other.trials)
    }

    /// The next trial: every coordinate changes by up to the reach. Until its cost is passed to
    /// [`Self::judge`], repeated calls return the same trial.
    pub fn propose(&self) -> Vec<f64> {
        let mut random = self.random();
        self.place.iter().map(|x| x + self.reach * (2.0 * share(&mut random) - 1.0)).collect()
    }

    /// Accepts or rejects the trial at `there`; a cost of `None` is never accepted.
    pub fn judge(&mut self, there: Vec<f64>, cost: Option<f64>) -> Verdict {
        let mut random = self.random();
        let luck = (0..=self.place.len()).map(|_| share(&mut random)).last().unwrap_or_default();
        let temperature = self.temperature();
        let taken = cost.filter(|cost| luck < ((self.cost - cost) / temperature).exp());
        self.reach = (self.reach * (FOLLOWS * (f64::from(u8::from(taken.is_some())) - TAKEN)).exp()).clamp(REACH[0], REACH[1]);
        self.trial += 1;
        let Some(cost) = taken else { return Verdict::Refused };
        (self.place, self.cost) = (there, cost);
        if cost < self.best.1 {
            self.best = (self.place.clone(), cost);
            return Verdict::Best;
        }
        Verdict::Taken
    }

    /// Random numbers that depend only on seed and number of the trial, so that a walk that is read
    /// back continues identically.
    fn random(&self) -> Xoshiro256PlusPlus {
        Xoshiro256PlusPlus::seed_from_u64(self.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(self.trial as u64))
    }
}

/// A uniform random number between zero and one.
fn share(random: &mut impl Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}
