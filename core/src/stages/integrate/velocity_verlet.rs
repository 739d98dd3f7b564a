//! Velocity Verlet of paper 004, eqs (9)-(10): `x += v dt + F dt^2/(2m)`, then `v += (F(t) +
//! F(t+dt)) dt/(2m)`.
//!
//! A substep has one evaluation of the forces, F(t). So (10) of the step before is closed first,
//! `v(t) = v(t-dt/2) + F(t) dt/(2m)`, then (9) is taken with `v(t+dt/2) = v(t) + F(t) dt/(2m)`: the
//! same positions, and between steps the node keeps the half-step velocity. Dampers see that one,
//! which breaks the circle that F(t+dt) needs v(t+dt) and v(t+dt) needs F(t+dt). After the first
//! half step it differs from symplectic Euler by nothing.

use super::FASTEST_M_PER_S;
use crate::fault::Fault;
use crate::lanes::ROW;
use crate::model::Model;
use crate::params::Tuned;
use crate::stages::region::Region;
use crate::state::State;

/// The step, and whether a step is open that is to be closed.
#[derive(Clone, Copy, Debug, Default)]
pub struct VelocityVerlet {
    under_way: bool,
}

impl VelocityVerlet {
    /// Moves the region's nodes by one substep; returns how many. Nodes outside stop: their step
    /// ends.
    ///
    /// # Errors
    /// [`Fault::Diverged`].
    pub fn advance(&mut self, model: &Model, tuned: &Tuned, state: &mut State, region: Region) -> Result<u16, Fault> {
        let dt = tuned.substep_s;
        let close = if self.under_way { 0.5 } else { 0.0 };
        self.under_way = true;
        let mut active = 0;
        for ((node, &step), rest) in state.nodes.iter_mut().zip(tuned.node_step.iter()).zip(model.nodes) {
            if step == 0.0 {
                continue;
            }
            if !region.contains(rest.rest_m) {
                node.v = [0.0; ROW];
                continue;
            }
            active += 1;
            let mut square = 0.0;
            for k in 0..ROW {
                let now = node.v[k] + node.f[k] * step * close;
                let half = now * tuned.keep + node.f[k] * step * 0.5;
                node.v[k] = half;
                node.x[k] += half * dt;
                square += half * half;
            }
            #[expect(clippy::neg_cmp_op_on_partial_ord, reason = "a NaN is not slower than the limit")]
            if !(square <= FASTEST_M_PER_S * FASTEST_M_PER_S) {
                return Err(Fault::Diverged);
            }
        }
        Ok(active)
    }
}
