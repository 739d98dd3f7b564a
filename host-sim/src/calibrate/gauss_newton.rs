//! Gauss-Newton with the adjoint's exact slopes: every round solves the regularised linear least squares of all errors in all unknowns.
//!
//! There are fewer measured numbers than unknowns, so the normal equations are solved on the side of the measurements:
//! `z = J^T (J J^T + I)^-1 (J z0 - r)` minimises `|r + J (z - z0)|^2 + |z|^2`.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::{CalibrateError, Objective, Round, Sweep};

/// A round that gains less than this share of the cost is the last.
const LEAST_GAIN: f64 = 0.01;
/// Shares of a step that are tried when the whole step does not pay.
const SHARES: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// Fits the unknowns; returns a record of every round, the uncalibrated patch first.
///
/// # Errors
/// The uncalibrated patch cannot be pressed.
pub fn fit(objective: &mut Objective, most: usize, progress: &mut dyn FnMut(&Round)) -> Result<Vec<Round>, CalibrateError> {
    let mut z = objective.place().to_vec();
    let (mut sweep, found) = objective.evaluate(&z, true)?;
    objective.accept(z.clone(), found);
    let mut rounds = vec![objective.round(&sweep, &z)];
    progress(&rounds[0]);
    for n in 0..most {
        let Some(step) = step(&sweep, &z) else { break };
        let before = rounds[n].cost;
        let mut better = None;
        for share in SHARES {
            let there: Vec<f64> = z.iter().zip(&step).map(|(z, s)| z + share * s).collect();
            // a press that finds no balance is a step too far
            if let Ok((sweep, found)) = objective.evaluate(&there, true) {
                let round = objective.round(&sweep, &there);
                if round.cost < before {
                    better = Some((there, sweep, found, round));
                    break;
                }
            }
        }
        let Some((there, next, found, round)) = better else { break };
        z.clone_from(&there);
        objective.accept(there, found);
        sweep = next;
        progress(&round);
        rounds.push(round);
        if round.cost > (1.0 - LEAST_GAIN) * before {
            break;
        }
    }
    Ok(rounds)
}

fn step(sweep: &Sweep, z: &[f64]) -> Option<Vec<f64>> {
    let (m, n) = (sweep.rows.len(), z.len());
    let j = Mat::from_fn(m, n, |r, c| sweep.rows[r][c]);
    let mut normal = &j * j.transpose();
    (0..m).for_each(|k| normal[(k, k)] += 1.0);
    let right = Mat::from_fn(m, 1, |r, _| sweep.rows[r].iter().zip(z).map(|(j, z)| j * z).sum::<f64>() - sweep.residuals[r]);
    let weights = normal.llt(Side::Lower).ok()?.solve(&right);
    let there = j.transpose() * weights;
    Some((0..n).map(|k| there[(k, 0)] - z[k]).collect())
}
