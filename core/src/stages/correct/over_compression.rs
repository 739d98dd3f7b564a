//! Over-compression correction of paper 004, eqs (11)-(13).

use super::shares;
use crate::lanes::{add, difference, scaled, sqrt, subtract};
use crate::model::Model;
use crate::params::Tuned;
use crate::state::State;

/// Pushes the ends of every spring shorter than `(1 - tau_c) l0` apart, one spring after the other,
/// each end by half of what is missing: `p_i += -C/2 n`, `p_j += C/2 n`, `n = (p_i - p_j)/|p_i -
/// p_j|`, `C < 0` (12)-(13; both lost in the text, reconstructed).
#[derive(Clone, Copy, Debug)]
pub struct OverCompression {
    /// Critical compression ratio `tau_c` (1).
    pub ratio: f32,
}

impl OverCompression {
    /// Moves the free nodes.
    pub fn correct(&self, model: &Model, tuned: &Tuned, state: &mut State) {
        for s in model.springs {
            let [i, j] = [s.i, s.j].map(usize::from);
            let (Some(a), Some(b)) = (state.nodes.get(i), state.nodes.get(j)) else { continue };
            let d = difference(&b.x, &a.x);
            let length = sqrt(d.iter().map(|c| c * c).sum());
            let missing = (1.0 - self.ratio) * (s.k_rest / s.k) - length;
            if !(missing > 0.0 && length > 0.0) {
                continue;
            }
            let [of_i, of_j] = shares(tuned, i, j);
            if let Some(node) = state.nodes.get_mut(i) {
                subtract(&mut node.x, &scaled(&d, of_i * missing / length));
            }
            if let Some(node) = state.nodes.get_mut(j) {
                add(&mut node.x, &scaled(&d, of_j * missing / length));
            }
        }
    }
}
