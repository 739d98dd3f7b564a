//! The papers' position fixes after a step. Off in the product: they act as a stiffness of about m/dt^2 (see `force::compensation`).
//!
//! The variant is a type, so an image holds only the one it runs.
//!
//! * in: positions after the step
//! * out: positions
//! * cost: nothing when off; about a spring pass when on
//! * may fail: never

use crate::lanes::{ROW, add, scaled, subtract};
use crate::lanes::{difference, sqrt};
use crate::model::Model;
use crate::params::Tuned;
use crate::state::State;

/// A fix of positions after each substep.
pub trait Correct {
    /// Moves nodes.
    fn correct(&self, model: &Model, tuned: &Tuned, state: &mut State);
}

/// No fix.
#[derive(Clone, Copy, Debug)]
pub struct Off;

impl Correct for Off {
    #[inline(always)]
    fn correct(&self, _: &Model, _: &Tuned, _: &mut State) {}
}

/// Over-stretching and over-compressing corrections, Jacobi, averaged over each node's springs (paper 000, eqs 6-8).
///
/// Positions only, as printed. Where one end is fixed, ours gives its share to the free end; the print says nothing.
#[derive(Clone, Copy, Debug)]
pub struct SpringLength {
    /// Critical stretching rate `tau_s` (1).
    pub stretch: f32,
    /// Critical compressing rate `tau_c` (1).
    pub compression: f32,
}

impl Correct for SpringLength {
    fn correct(&self, model: &Model, tuned: &Tuned, state: &mut State) {
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
            let free = |n: usize| tuned.node_step.get(n).is_some_and(|&w| w > 0.0);
            let share = if free(i) && free(j) { 0.5 } else { 1.0 };
            let move_by = if length > 0.0 { scaled(&d, share * wrong / length) } else { [0.0; ROW] };
            if let Some(node) = state.nodes.get_mut(i) {
                add(&mut node.f, &move_by);
                node.p += 1.0;
            }
            if let Some(node) = state.nodes.get_mut(j) {
                subtract(&mut node.f, &move_by);
                node.p += 1.0;
            }
        }
        for (node, &step) in state.nodes.iter_mut().zip(tuned.node_step) {
            if step > 0.0 && node.p > 0.0 {
                let fix = scaled(&node.f, 1.0 / node.p);
                add(&mut node.x, &fix);
            }
        }
    }
}
