//! Velocity Verlet of paper 004, eqs (9)-(10): `x += v dt + F dt^2/(2m)`, then `v += (F(t) +
//! F(t+dt)) dt/(2m)`.
//!
//! A substep has one evaluation of the forces, F(t). So (10) of the step before is closed first,
//! `v(t) = v(t-dt/2) + F(t) dt/(2m)`, then (9) is taken with `v(t+dt/2) = v(t) + F(t) dt/(2m)`: the
//! same positions, and between steps the node keeps the half-step velocity. Dampers see that one,
//! which breaks the circle that F(t+dt) needs v(t+dt) and v(t+dt) needs F(t+dt). After the first
//! half step it differs from symplectic Euler by nothing.

use palpate::{Fault, Model, State, Tuned};

use super::region::{Region, advance_within};

/// The step, and whether a step is open that is to be closed.
#[derive(Clone, Copy, Debug, Default)]
pub struct VelocityVerlet {
    under_way: bool,
    /// Nodes that move; all nodes if `None`.
    pub region: Option<Region>,
}

impl VelocityVerlet {
    /// Moves the region's nodes by one substep; returns how many. Nodes outside the region stop:
    /// their step ends.
    ///
    /// # Errors
    /// [`Fault::Diverged`].
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
