//! Direction correction of paper 000, eq (9): a spring may rotate by at most theta between two
//! checks.

use palpate::{Model, State, Tuned, Vector3};

use super::averaged::Averaged;
use super::shares;

/// Rotates springs back to within theta of the direction that they had when the positions `x^p`
/// were last recorded.
///
/// The paper gives the constraint and says that its update follows like that of (6). With `C =
/// theta - phi`, where phi is the angle of rotation, the gradients at the ends are `-t/l` and
/// `t/l`, where t is the unit vector perpendicular to the spring towards its old direction. The
/// step that brings C to zero is then `-C l/2 t`, averaged over the springs of a node as in (7).
/// For a spring that points exactly backwards t is undefined; such a spring is not corrected.
#[derive(Debug)]
pub struct SpringDirection<'a> {
    /// Critical angle theta [rad], above 0 and below pi.
    pub angle_rad: f32,
    /// Number of steps between two checks.
    pub every: u16,
    /// Recorded positions `x^p` [m], shape \[nodes\]; the caller initialises them with the rest
    /// positions.
    pub before_m: &'a mut [[f32; 3]],
    /// Number of steps since the last check.
    pub age: u16,
}

impl SpringDirection<'_> {
    /// Moves the free nodes, in steps in which a check is due.
    pub fn correct(&mut self, model: &Model, tuned: &Tuned, state: &mut State, averaged: &mut Averaged) {
        let least_cosine = libm::cosf(self.angle_rad);
        averaged.clear(state.nodes().len());
        for s in model.springs {
            let [i, j] = [s.i, s.j].map(usize::from);
            let d = state.nodes()[j].position_m() - state.nodes()[i].position_m();
            let fix = self.turn_back(i, j, d, least_cosine);
            let [of_i, of_j] = shares(tuned, i, j);
            averaged.add(i, -(fix * of_i));
            averaged.add(j, fix * of_j);
        }
        averaged.apply(tuned, state);
        self.age = self.age.saturating_add(1);
        if self.age >= self.every {
            self.age = 0;
            for (before, node) in self.before_m.iter_mut().zip(state.nodes()) {
                *before = node.position_m().into();
            }
        }
    }

    /// Displacement of end j relative to end i that rotates the spring back to theta [m]; zero if
    /// the angle is within theta.
    fn turn_back(&self, i: usize, j: usize, d: Vector3<f32>, least_cosine: f32) -> Vector3<f32> {
        let [a, b] = [i, j].map(|n| Vector3::from(self.before_m[n]));
        let old = b - a;
        let (length, old_length) = (d.dot(&d).sqrt(), old.dot(&old).sqrt());
        if !(length > 0.0 && old_length > 0.0) {
            return Vector3::zeros();
        }
        let cosine = d.dot(&old) / (length * old_length);
        if cosine >= least_cosine {
            return Vector3::zeros();
        }
        // perpendicular to the spring, towards its old direction
        let across = old * (1.0 / old_length) - d * (cosine / length);
        let sine = across.dot(&across).sqrt();
        if sine <= 1e-3 {
            return Vector3::zeros();
        }
        let excess = libm::acosf(cosine.clamp(-1.0, 1.0)) - self.angle_rad;
        across * (excess * length / sine)
    }
}
