//! Gauss-Newton with the exact derivatives of the adjoint. Every round solves the regularised
//! linear least-squares problem of all errors in all unknowns.
//!
//! There are fewer measurements than unknowns, so the normal equations are solved in the space of
//! the measurements: `z = J^T (J J^T + I)^-1 (J z0 - r)` minimises `|r + J (z - z0)|^2 + |z|^2`.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::{CalibrateError, Objective, Round, Settings, Sweep};

/// Damping of the first round (Levenberg, Marquardt): weight that pulls the unknowns toward those
/// of the previous round, divided by the weight of their prior (1).
const FIRST_HOLD: f64 = 100.0;
/// Damping below which a step is hardly shortened (1).
const FREE: f64 = 1.0;
/// Factor by which the damping is increased (1) after a step that gains nothing, or less than the
/// share `FAIR` of the gain that the linear model predicts. A step that gains more than the share
/// `GOOD` reduces the damping.
const LONGER_HOLD: f64 = 4.0;
const GOOD: f64 = 0.7;
const FAIR: f64 = 0.3;
const MOST_TRIES: usize = 6;

/// Fits the unknowns; returns a record of every round, beginning with the uncalibrated patch.
///
/// # Errors
/// Fails if the uncalibrated patch cannot be pressed.
pub fn fit(
    objective: &mut Objective,
    settings: &Settings,
    progress: &mut dyn FnMut(&Round),
) -> Result<Vec<Round>, CalibrateError> {
    let mut z = objective.place().to_vec();
    let (mut sweep, found) = objective.evaluate(&z, true)?;
    objective.accept(z.clone(), found);
    let mut rounds = vec![objective.round(&sweep, &z)];
    progress(&rounds[0]);
    let mut hold = FIRST_HOLD;
    for n in 0..settings.rounds {
        let before = rounds[n].cost;
        let (mut better, mut kept) = (None, 0.0);
        for tries in 0..MOST_TRIES {
            let Some(there) = step(&sweep, &z, hold) else { break };
            let promised = before - linear_cost(&sweep, &z, &there);
            // the shortened step could not gain as much as a round must gain
            if tries > 0 && promised < settings.least_gain * before {
                break;
            }
            // many presses without equilibrium mean that the step was too long; presses that are
            // lost in one of the two evaluations are left out of both costs
            if let Ok((next, found)) = objective.evaluate(&there, true) {
                let round = objective.round(&next, &there);
                let gained = before - sweep.known_here_alone(&next) - (round.cost - next.known_here_alone(&sweep));
                if gained > 0.0 {
                    kept = gained / promised;
                    better = Some((there, next, found, round, gained));
                    break;
                }
            }
            hold *= LONGER_HOLD;
        }
        let Some((there, next, found, round, gained)) = better else { break };
        hold *= if kept > GOOD {
            0.2
        } else if kept > FAIR {
            1.0
        } else {
            LONGER_HOLD
        };
        z.clone_from(&there);
        objective.accept(there, found);
        sweep = next;
        progress(&round);
        rounds.push(round);
        // a damped step gains little; the fit ends only if a nearly undamped step gains little
        if hold < FREE && gained < settings.least_gain * before {
            break;
        }
    }
    Ok(rounds)
}

/// Returns the cost predicted by the linear model at `there`.
fn linear_cost(sweep: &Sweep, z: &[f64], there: &[f64]) -> f64 {
    let moved: Vec<f64> = there.iter().zip(z).map(|(a, b)| a - b).collect();
    let residual = |(row, r): (&Vec<f64>, &f64)| r + row.iter().zip(&moved).map(|(j, d)| j * d).sum::<f64>();
    let misfit: f64 = sweep.rows.iter().zip(&sweep.residuals).map(residual).map(|r| r * r).sum();
    misfit + there.iter().map(|z| z * z).sum::<f64>()
}

/// Damped Gauss-Newton step. Returns the minimum of the linear model when each unknown is also
/// pulled toward its present value, with `hold` times the weight of its prior.
fn step(sweep: &Sweep, z: &[f64], hold: f64) -> Option<Vec<f64>> {
    let (m, n) = (sweep.rows.len(), z.len());
    let j = Mat::from_fn(m, n, |r, c| sweep.rows[r][c]);
    let mut normal = &j * j.transpose();
    (0..m).for_each(|k| normal[(k, k)] += 1.0 + hold);
    // the prior at zero and the damping toward z combine into one prior between them
    let between = hold / (1.0 + hold);
    let right = |r: usize| sweep.rows[r].iter().zip(z).map(|(j, z)| j * z * (1.0 - between)).sum::<f64>() - sweep.residuals[r];
    let weights = normal.llt(Side::Lower).ok()?.solve(&Mat::from_fn(m, 1, |r, _| right(r)));
    let there = j.transpose() * weights;
    Some((0..n).map(|k| between * z[k] + there[(k, 0)]).collect())
}
