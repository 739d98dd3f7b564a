//! The papers' position fixes after a step. The product has none: they act as a stiffness of about
//! m/dt^2 (see `force::compensation`), so the force depends on the time step.
//!
//! * in: positions after the step
//! * out: positions; velocities stay, as both papers print it
//! * cost: about a spring pass each
//! * may fail: never

pub mod direction;
pub mod length;
pub mod over_compression;

use crate::params::Tuned;

/// Shares of a correction that the two ends of a spring take. Where one end is fixed the free one
/// takes all; the papers say nothing of that.
#[inline(always)]
fn shares(tuned: &Tuned, i: usize, j: usize) -> [f32; 2] {
    let free = |n: usize| tuned.node_step.get(n).is_some_and(|&w| w > 0.0);
    match (free(i), free(j)) {
        (true, true) => [0.5, 0.5],
        (true, false) => [1.0, 0.0],
        (false, true) => [0.0, 1.0],
        (false, false) => [0.0, 0.0],
    }
}
