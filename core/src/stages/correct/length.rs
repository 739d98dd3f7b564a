//! Over-stretching and over-compressing corrections of paper 000, eqs (6)-(8): Jacobi, averaged
//! over each node's springs.

use super::shares;
use crate::lanes::{ROW, add, difference, scaled, sqrt, subtract};
use crate::model::Model;
use crate::params::Tuned;
use crate::state::State;

/// Brings every spring back between `(1 - tau_c) l0` and `(1 + tau_s) l0`.
///
/// As printed the correction of a node is divided by the number of *all* its springs (7), whose
/// letter m is not the mass: each end divides by another number, so momentum is not kept. A
/// compressed spring is pushed apart; the print gives only the stretched one's sign.
#[derive(Clone, Copy, Debug)]
pub struct SpringLength {
    /// Critical stretching rate `tau_s` (1).
    pub stretch: f32,
    /// Critical compressing rate `tau_c` (1).
    pub compression: f32,
}

impl SpringLength {
    /// Moves the free nodes.
    pub fn correct(&self, model: &Model, tuned: &Tuned, state: &mut State) {
        // forces are spent: their rows hold the summed corrections, the pressures the spring counts
        for node in state.nodes.iter_mut() {
            node.f = [0.0; ROW];
            node.p = 0.0;
        }
        for s in model.springs {
            let [i, j] = [s.i, s.j].map(usize::from);
            let (Some(a), Some(b)) = (state.nodes.get(i), state.nodes.get(j)) else { continue };
            let d = difference(&b.x, &a.x);
            let length = sqrt(d.iter().map(|c| c * c).sum());
            let rest = s.k_rest / s.k;
            let (longest, shortest) = ((1.0 + self.stretch) * rest, (1.0 - self.compression) * rest);
            let wrong = if length > longest { length - longest } else { (length - shortest).clamp(f32::MIN, 0.0) };
            let [of_i, of_j] = shares(tuned, i, j);
            let fix = if length > 0.0 { scaled(&d, wrong / length) } else { [0.0; ROW] };
            if let Some(node) = state.nodes.get_mut(i) {
                add(&mut node.f, &scaled(&fix, of_i));
                node.p += 1.0;
            }
            if let Some(node) = state.nodes.get_mut(j) {
                subtract(&mut node.f, &scaled(&fix, of_j));
                node.p += 1.0;
            }
        }
        for (node, &step) in state.nodes.iter_mut().zip(tuned.node_step.iter()) {
            if step > 0.0 && node.p > 0.0 {
                let fix = scaled(&node.f, 1.0 / node.p);
                add(&mut node.x, &fix);
            }
        }
    }
}
