//! Velocity Verlet of paper 004, eqs (9)-(10): `x += v dt + F dt^2/(2m)`, then `v += (F(t) +
//! F(t+dt)) dt/(2m)`.
//!
//! A substep evaluates the forces only once, at t. It therefore first completes (10) of the
//! previous step, `v(t) = v(t-dt/2) + F(t) dt/(2m)`, and then performs (9) with `v(t+dt/2) = v(t) +
//! F(t) dt/(2m)`. The positions are those of the paper; between steps a node stores the half-step
//! velocity. Dampers use that velocity, which resolves the circular dependence between F(t+dt) and
//! v(t+dt). After the first half step the method is identical to symplectic Euler.

use palpate::{Fault, Model, State, Tuned};

use super::region::{Region, advance_within};

/// Velocity Verlet, and whether the velocity update of a previous step has to be completed.
#[derive(Clone, Copy, Debug, Default)]
pub struct VelocityVerlet {
    under_way: bool,
    /// Region of the active nodes; `None` makes all nodes active.
    pub region: Option<Region>,
}

impl VelocityVerlet {
    /// Moves the nodes of the region by one substep; returns their number. Nodes outside the region
    /// lose their velocity.
    pub fn advance(&mut self, model: &Model, tuned: &Tuned, state: &mut State) -> Result<u16, Fault> {
        let keep = tuned.velocity_kept();
        let close = if self.under_way { 0.5 } else { 0.0 };
        self.under_way = true;
        advance_within(self.region, model, tuned, state, |v, f, step| {
            let now = v + f * step * close;
            now * keep + f * step * 0.5
        })
    }
}
