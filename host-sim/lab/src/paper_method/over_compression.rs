//! Over-compression correction of paper 004, eqs (11)-(13).

use palpate::{Model, State, Tuned};

use super::shares;

/// Pushes the ends of every spring that is shorter than `(1 - tau_c) l0` apart, one spring after
/// the other, each end by half of the missing length: `p_i += -C/2 n`, `p_j += C/2 n`, `n = (p_i -
/// p_j)/|p_i - p_j|`, `C < 0` (12)-(13, which are missing from the text and were reconstructed).
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
            let [a, b] = [i, j].map(|n| state.nodes()[n]);
            let d = b.position_m() - a.position_m();
            let length = d.dot(&d).sqrt();
            let missing = (1.0 - self.ratio) * (s.k_rest / s.k) - length;
            if !(missing > 0.0 && length > 0.0) {
                continue;
            }
            let [of_i, of_j] = shares(tuned, i, j);
            state.place(i, a.position_m() - d * (of_i * missing / length), a.velocity_m_per_s());
            state.place(j, b.position_m() + d * (of_j * missing / length), b.velocity_m_per_s());
        }
    }
}
