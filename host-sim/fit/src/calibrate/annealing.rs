//! Simulated annealing with the schedule of paper 004 (sections 2.2 and 3.4), for comparison with
//! [`super::gauss_newton`] on the same objective.
//!
//! There are two unknowns, as in the paper: one multiplier for all springs and one for all nodal
//! volume stiffnesses. The paper's second unknown is the damping, which does not affect a press at
//! rest. Its objective is the Hausdorff distance; here the objective is the cost that all fits
//! share, so temperatures are in units of that cost. The walk starts at the uncalibrated patch, not
//! at a random place.
//!
//! Schedule and walk are those of [`super::schedule`]. The annealing of `argmin` cools after every
//! trial and accepts a worse place with a probability other than Metropolis's.

use super::schedule::{Schedule, Verdict, Walk};
use super::{CalibrateError, Objective, Round};

/// Number of evaluations of the whole schedule, including the start.
pub const SCHEDULE_EVALUATIONS: usize = 1 + Schedule::PAPER.length();

const SEED: u64 = 4;

/// Fits the two multipliers with at most `most_evaluations`; returns a record of the start and of
/// every trial that was better than all earlier ones. The objective is left at the best trial. With
/// fewer evaluations than [`SCHEDULE_EVALUATIONS`] all temperatures are used, each with fewer
/// trials. Coordinates are in prior widths.
///
/// # Errors
/// Fails if the uncalibrated patch cannot be pressed.
pub fn fit(
    objective: &mut Objective,
    most_evaluations: usize,
    progress: &mut dyn FnMut(&Round),
) -> Result<Vec<Round>, CalibrateError> {
    let moved = objective.unknowns().shared_springs_and_nodes();
    let start = objective.place().to_vec();
    let (sweep, found) = objective.evaluate(&start, false)?;
    objective.accept(start.clone(), found);
    let mut rounds = vec![objective.round(&sweep, &start)];
    progress(&rounds[0]);
    let trials = most_evaluations.min(SCHEDULE_EVALUATIONS).saturating_sub(1);
    let place = moved.iter().map(|&k| start[k]).collect();
    let mut walk = Walk::start(Schedule::PAPER, trials, SEED, place, rounds[0].cost);
    while !walk.is_done() {
        let there = walk.propose();
        let mut full = start.clone();
        moved.iter().zip(&there).for_each(|(&k, x)| full[k] = *x);
        // the cost must count every press that was counted at the start
        let tried = objective.evaluate(&full, false).ok().filter(|(there, _)| there.lost.iter().all(|n| sweep.lost.contains(n)));
        let tried = tried.map(|(sweep, found)| (objective.round(&sweep, &full), found));
        let verdict = walk.judge(there, tried.as_ref().map(|(round, _)| round.cost));
        if let (Verdict::Best, Some((round, found))) = (verdict, tried) {
            objective.accept(full, found);
            progress(&round);
            rounds.push(round);
        }
    }
    Ok(rounds)
}
