//! L-BFGS (Liu and Nocedal 1989, through `argmin`) on the objective of [`super::gauss_newton`], to be compared with it: it sees only the cost and its
//! gradient `2 J^T r + 2 z`, not the slopes of every error.
//!
//! The cost is scaled so that the first step, straight down, is as long as the best one of the linear model; without that it would be thousands of
//! prior widths. Lines are searched by Moré and Thuente (1994), which keeps the curvature pairs positive.

use std::cell::RefCell;

use argmin::core::{CostFunction, Error, Executor, Gradient};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use thiserror::Error;

use super::{CalibrateError, Objective, Round, Sweep};

/// Steps remembered as curvature.
const MEMORY: usize = 10;
/// A press without balance costs this many times what the start does.
const NO_BALANCE: f64 = 2.0;

/// Fits the unknowns with at most `most_evaluations` of cost and gradient together; returns a record of the start and of every evaluation
/// that was better than all before it. The best is what the objective is left at.
///
/// # Errors
/// The uncalibrated patch cannot be pressed.
pub fn fit(
    objective: &mut Objective,
    most_evaluations: usize,
    progress: &mut dyn FnMut(&Round),
) -> Result<Vec<Round>, CalibrateError> {
    let z = objective.place().to_vec();
    let (sweep, found) = objective.evaluate(&z, true)?;
    objective.accept(z.clone(), found);
    let round = objective.round(&sweep, &z);
    progress(&round);
    let start = Point { cost: round.cost, gradient: gradient(&sweep, &z), z };
    let unit = straight_down(&sweep, &start.gradient);
    let search = RefCell::new(Search {
        objective,
        progress,
        rounds: vec![round],
        best_z: start.z.clone(),
        last: start.clone(),
        left: most_evaluations.saturating_sub(1),
        unit,
    });
    // `argmin` is not told the start's cost, which it would take for convergence: it asks, and `last` answers.
    // However it ends, converged, out of evaluations or on a line without a way down, the best is already accepted
    let _ = Executor::new(Asked(&search), LBFGS::new(MoreThuenteLineSearch::new(), MEMORY))
        .configure(|state| state.param(start.z))
        .timer(false)
        .run();
    Ok(search.into_inner().rounds)
}

/// Gradient of the cost, misfit plus ridge, at the place `z` where a sweep with slopes was made.
#[must_use]
pub fn gradient(sweep: &Sweep, z: &[f64]) -> Vec<f64> {
    let mut gradient = scaled(z, 2.0);
    for (r, row) in sweep.residuals.iter().zip(&sweep.rows) {
        gradient.iter_mut().zip(row).for_each(|(g, j)| *g += 2.0 * r * j);
    }
    gradient
}

/// How far to go along minus the gradient, as a multiple of it, until the linear model `|r + J s|^2 + |z + s|^2` is least.
fn straight_down(sweep: &Sweep, gradient: &[f64]) -> f64 {
    let squared = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
    let along = |row: &Vec<f64>| row.iter().zip(gradient).map(|(j, g)| j * g).sum::<f64>();
    let bend = squared(&sweep.rows.iter().map(along).collect::<Vec<_>>()) + squared(gradient);
    if bend > 0.0 { squared(gradient) / (2.0 * bend) } else { 1.0 }
}

fn scaled(v: &[f64], by: f64) -> Vec<f64> {
    v.iter().map(|x| by * x).collect()
}

/// The budget is used up: what ends `argmin`'s loop from inside.
#[derive(Debug, Error)]
#[error("no evaluations left")]
struct Spent;

#[derive(Clone)]
struct Point {
    z: Vec<f64>,
    cost: f64,
    gradient: Vec<f64>,
}

struct Search<'s, 't> {
    objective: &'s mut Objective<'t>,
    progress: &'s mut dyn FnMut(&Round),
    rounds: Vec<Round>,
    best_z: Vec<f64>,
    last: Point,
    left: usize,
    /// What `argmin` sees is this times the cost.
    unit: f64,
}

impl Search<'_, '_> {
    /// Cost and gradient come from one evaluation; `argmin` asks for them one after the other.
    fn at(&mut self, z: &[f64]) -> Result<&Point, Error> {
        if self.last.z != z {
            self.left = self.left.checked_sub(1).ok_or(Spent)?;
            self.last = match self.objective.evaluate(z, true) {
                Ok((sweep, found)) => {
                    let round = self.objective.round(&sweep, z);
                    if self.rounds.last().is_none_or(|best| round.cost < best.cost) {
                        self.objective.accept(z.to_vec(), found);
                        self.best_z = z.to_vec();
                        (self.progress)(&round);
                        self.rounds.push(round);
                    }
                    Point { z: z.to_vec(), cost: round.cost, gradient: gradient(&sweep, z) }
                }
                Err(_) => self.without_balance(z),
            };
        }
        Ok(&self.last)
    }

    /// A wall, rising away from the best place: a line search turns back from it and goes on.
    fn without_balance(&self, z: &[f64]) -> Point {
        let cost = NO_BALANCE * self.rounds[0].cost;
        let away: Vec<f64> = z.iter().zip(&self.best_z).map(|(z, best)| z - best).collect();
        let squared: f64 = away.iter().map(|a| a * a).sum();
        Point { z: z.to_vec(), cost, gradient: scaled(&away, cost / squared.max(f64::MIN_POSITIVE)) }
    }
}

/// The search as `argmin` asks it.
struct Asked<'c, 's, 't>(&'c RefCell<Search<'s, 't>>);

impl CostFunction for Asked<'_, '_, '_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, z: &Vec<f64>) -> Result<f64, Error> {
        let mut search = self.0.borrow_mut();
        let unit = search.unit;
        search.at(z).map(|point| unit * point.cost)
    }
}

impl Gradient for Asked<'_, '_, '_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, z: &Vec<f64>) -> Result<Vec<f64>, Error> {
        let mut search = self.0.borrow_mut();
        let unit = search.unit;
        search.at(z).map(|point| scaled(&point.gradient, unit))
    }
}
