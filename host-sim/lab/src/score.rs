//! Training score of paper 004, section 3.6: three physicians mark every intern before and after
//! the training, and their marks are combined into one value per intern.
//!
//! Equation (14): `y_i = sum_j x_ij / 10 * w_j`, with marks `x_ij` from 0 to 10 and weights of 0.45
//! for the chief, 0.35 for the associate chief and 0.20 for the attending physician. The paper
//! compares the groups by inspection; here a permutation test gives the probability that chance
//! alone explains a difference ([`statistics`]).

pub mod statistics;
pub mod table_1;

/// Weights of the chief, the associate chief and the attending physician (1).
pub const PAPER_WEIGHTS: [f64; 3] = [0.45, 0.35, 0.20];

/// Highest mark that a physician can give.
pub const FULL_MARK: f64 = 10.0;

/// Equation (14): the value, from 0 to 1, that follows from marks from 0 to 10.
pub fn value(marks: [f64; 3], weights: [f64; 3]) -> f64 {
    marks.iter().zip(weights).map(|(x, w)| x / FULL_MARK * w).sum()
}
