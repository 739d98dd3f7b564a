//! Simulated annealing with the schedule of paper 004 (sections 2.2 and 3.4), to be compared with [`super::gauss_newton`] on the same objective.
//!
//! Two unknowns, as there: one multiplier on all springs and one on all nodal volume. The paper's second is the damping, which a press at rest does not
//! feel; its objective is the Hausdorff distance, here it is the cost that all fits share, so a temperature is in units of that cost. It starts at the
//! uncalibrated patch, not at random, and as the paper does not say how far a trial goes, the reach follows the share of trials taken.
//!
//! The loop is written out: `argmin`'s annealing cools after every trial and takes a worse place with another probability than Metropolis's.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};

use super::{CalibrateError, Objective, Round};

/// First temperature, in units of the cost.
pub const FIRST_TEMPERATURE: f64 = 100.0;
/// Cooling ends here.
pub const LAST_TEMPERATURE: f64 = 0.001;
/// Each temperature over the one before.
pub const COOLING: f64 = 0.98;
/// Trials at each temperature.
pub const TRIALS: usize = 200;
/// Evaluations of the whole schedule, the start included.
pub const SCHEDULE_EVALUATIONS: usize = 1 + temperatures() * TRIALS;

/// Furthest and nearest trial [prior widths].
const REACH: [f64; 2] = [1e-4, 1.0];
/// Share of trials that the reach is to make worth taking, and how fast it follows.
const TAKEN: f64 = 0.44;
const FOLLOWS: f64 = 0.2;
const SEED: u64 = 4;

const fn temperatures() -> usize {
    let (mut temperature, mut count) = (FIRST_TEMPERATURE, 0);
    while temperature > LAST_TEMPERATURE {
        temperature *= COOLING;
        count += 1;
    }
    count
}

/// Fits the two multipliers with at most `most_evaluations`; returns a record of the start and of every trial that was better than all before it. The best
/// is what the objective is left at. With less than [`SCHEDULE_EVALUATIONS`] all temperatures are gone through with fewer trials each.
///
/// # Errors
/// The uncalibrated patch cannot be pressed.
pub fn fit(
    objective: &mut Objective,
    most_evaluations: usize,
    progress: &mut dyn FnMut(&Round),
) -> Result<Vec<Round>, CalibrateError> {
    let moved = objective.unknowns().shared_springs_and_nodes();
    let mut here = objective.place().to_vec();
    let (sweep, found) = objective.evaluate(&here, false)?;
    objective.accept(here.clone(), found);
    let mut rounds = vec![objective.round(&sweep, &here)];
    progress(&rounds[0]);
    let (mut cost, mut best, mut reach) = (rounds[0].cost, rounds[0].cost, REACH[1]);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(SEED);
    let trials = most_evaluations.min(SCHEDULE_EVALUATIONS).saturating_sub(1);
    for trial in 0..trials {
        let temperature = FIRST_TEMPERATURE * COOLING.powi((trial * temperatures() / trials) as i32);
        let mut there = here.clone();
        moved.iter().for_each(|&k| there[k] += reach * (2.0 * share(&mut random) - 1.0));
        // a press without balance is never taken
        let tried = objective.evaluate(&there, false).ok().map(|(sweep, found)| (objective.round(&sweep, &there), found));
        let luck = share(&mut random);
        let tried = tried.filter(|(round, _)| luck < ((cost - round.cost) / temperature).exp());
        let taken = if tried.is_some() { 1.0 } else { 0.0 };
        reach = (reach * (FOLLOWS * (taken - TAKEN)).exp()).clamp(REACH[0], REACH[1]);
        let Some((round, found)) = tried else { continue };
        (here, cost) = (there, round.cost);
        if cost < best {
            best = cost;
            objective.accept(here.clone(), found);
            progress(&round);
            rounds.push(round);
        }
    }
    Ok(rounds)
}

/// Evenly between zero and one.
fn share(random: &mut impl RngCore) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}
