//! Over-stretching and over-compressing corrections of paper 000, eqs (6)-(8): a Jacobi iteration,
//! averaged over the springs of each node.

use palpate::{Model, State, Tuned, Vector3};

use super::averaged::Averaged;
use super::shares;

/// Brings the length of every spring back between `(1 - tau_c) l0` and `(1 + tau_s) l0`.
///
/// As printed, the correction of a node is divided by the number of *all* its springs (7), whose
/// symbol m is not the mass. The two ends of a spring divide by different numbers, so momentum is
/// not conserved. The ends of a compressed spring are pushed apart; the paper prints only the sign
/// for a stretched one.
#[derive(Clone, Copy, Debug)]
pub struct SpringLength {
    /// Critical stretching rate `tau_s` (1).
    pub stretch: f32,
    /// Critical compressing rate `tau_c` (1).
    pub compression: f32,
}

impl SpringLength {
    /// Moves the free nodes.
    pub fn correct(&self, model: &Model, tuned: &Tuned, state: &mut State, averaged: &mut Averaged) {
        averaged.clear(state.nodes().len());
        for s in model.springs {
            let [i, j] = [s.i, s.j].map(usize::from);
            let d = state.nodes()[j].position_m() - state.nodes()[i].position_m();
            let length = d.dot(&d).sqrt();
            let rest = s.k_rest / s.k;
            let (longest, shortest) = ((1.0 + self.stretch) * rest, (1.0 - self.compression) * rest);
            let wrong = if length > longest { length - longest } else { (length - shortest).clamp(f32::MIN, 0.0) };
            let [of_i, of_j] = shares(tuned, i, j);
            let fix = if length > 0.0 { d * (wrong / length) } else { Vector3::zeros() };
            averaged.add(i, fix * of_i);
            averaged.add(j, -(fix * of_j));
        }
        averaged.apply(tuned, state);
    }
}
