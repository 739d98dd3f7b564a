//! Direction correction of paper 000, eq (9): no spring turns by more than theta between two looks.

use crate::lanes::{ROW, Row, add, difference, scaled, sqrt, subtract};
use crate::model::Model;
use crate::params::Tuned;
use crate::stages::correct::shares;
use crate::state::State;

/// Turns springs back to within theta of where they pointed when positions `x^p` were last taken.
///
/// The paper gives the constraint and says that its update follows as that of (6). With `C =
/// theta - phi`, `phi` the angle, its gradient at the ends is `-t/l` and `t/l`, t the unit vector across
/// the spring toward its old direction; the step that closes C is then `-C l/2 t`, averaged over a
/// node's springs as in (7). A spring that points exactly backwards has no such t and is left
/// alone.
#[derive(Debug)]
pub struct SpringDirection<'a> {
    /// Critical angle theta [rad], above 0 and below pi.
    pub angle_rad: f32,
    /// Steps between two looks.
    pub every: u16,
    /// `x^p` [m], shape \[nodes\]; the caller fills it with the rest positions.
    pub before_m: &'a mut [[f32; 3]],
    /// Steps since the last look.
    pub age: u16,
}

impl SpringDirection<'_> {
    /// Moves the free nodes.
    pub fn correct(&mut self, model: &Model, tuned: &Tuned, state: &mut State) {
        let least_cosine = libm::cosf(self.angle_rad);
        for node in state.nodes.iter_mut() {
            node.f = [0.0; ROW];
            node.p = 0.0;
        }
        for s in model.springs {
            let [i, j] = [s.i, s.j].map(usize::from);
            let (Some(a), Some(b)) = (state.nodes.get(i), state.nodes.get(j)) else { continue };
            let fix = self.turn_back(i, j, &difference(&b.x, &a.x), least_cosine);
            let [of_i, of_j] = shares(tuned, i, j);
            if let Some(node) = state.nodes.get_mut(i) {
                subtract(&mut node.f, &scaled(&fix, of_i));
                node.p += 1.0;
            }
            if let Some(node) = state.nodes.get_mut(j) {
                add(&mut node.f, &scaled(&fix, of_j));
                node.p += 1.0;
            }
        }
        for (node, &step) in state.nodes.iter_mut().zip(tuned.node_step.iter()) {
            if step > 0.0 && node.p > 0.0 {
                let fix = scaled(&node.f, 1.0 / node.p);
                add(&mut node.x, &fix);
            }
        }
        self.age = self.age.saturating_add(1);
        if self.age >= self.every {
            self.age = 0;
            for (before, node) in self.before_m.iter_mut().zip(state.nodes.iter()) {
                *before = node.position_m().into();
            }
        }
    }

    /// How far end j is to go, seen from end i, so that the spring turns back to theta [m]; zero
    /// within theta.
    fn turn_back(&self, i: usize, j: usize, d: &Row, least_cosine: f32) -> Row {
        const NONE: Row = [0.0; ROW];
        let (Some(a), Some(b)) = (self.before_m.get(i), self.before_m.get(j)) else { return NONE };
        let mut old = NONE;
        for k in 0..3 {
            old[k] = b[k] - a[k];
        }
        let dot = |u: &Row, v: &Row| -> f32 { u[0] * v[0] + u[1] * v[1] + u[2] * v[2] };
        let (length, old_length) = (sqrt(dot(d, d)), sqrt(dot(&old, &old)));
        if !(length > 0.0 && old_length > 0.0) {
            return NONE;
        }
        let cosine = dot(d, &old) / (length * old_length);
        if cosine >= least_cosine {
            return NONE;
        }
        // across the spring, toward where it pointed
        let mut across = scaled(&old, 1.0 / old_length);
        subtract(&mut across, &scaled(d, cosine / length));
        let sine = sqrt(dot(&across, &across));
        if sine <= 1e-3 {
            return NONE;
        }
        let excess = libm::acosf(cosine.clamp(-1.0, 1.0)) - self.angle_rad;
        scaled(&across, excess * length / sine)
    }
}
