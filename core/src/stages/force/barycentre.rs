//! Volume force of paper 004, eq (2): each corner of a tet is pushed along the line from the tet's
//! barycentre.
//!
//! `F_i = -sum_w c (V_w - V_w0) (p_i - b_w)/|p_i - b_w|`. Unit vectors do not add up to zero: the
//! tet pushes itself, momentum is not kept. The print shows no coefficient c; without one the unit
//! is m^3. Kept as the paper has it; the product's `volume` is the gradient of an energy.
//!
//! * in: positions
//! * out: adds to `node.f`
//! * cost: about two springs a corner
//! * may fail: never

use crate::lanes::{ROW, add, difference, scaled, sqrt};
use crate::model::{Model, Tet};
use crate::params::Tuned;
use crate::state::{State, node};

/// The force of (2).
#[derive(Clone, Copy, Debug)]
pub struct BarycentreForce {
    /// Coefficient c [Pa/m].
    pub coefficient_pa_per_m: f32,
}

impl BarycentreForce {
    /// Adds the forces over E [N/Pa].
    pub fn push(&self, model: &Model, tuned: &Tuned, state: &mut State) {
        let over_modulus = self.coefficient_pa_per_m / tuned.youngs_modulus_pa;
        for tet in model.tets {
            let corners = tet.node.map(|n| node(state.nodes, n).x);
            let mut barycentre = [0.0; ROW];
            for x in &corners {
                add(&mut barycentre, &scaled(x, 0.25));
            }
            let growth_m3 = volume_m3(&corners) - rest_volume_m3(tet);
            for (n, x) in tet.node.into_iter().zip(&corners) {
                let out = difference(x, &barycentre);
                let length = sqrt(out.iter().map(|c| c * c).sum());
                if let Some(node) = state.nodes.get_mut(usize::from(n))
                    && length > 0.0
                {
                    add(&mut node.f, &scaled(&out, -over_modulus * growth_m3 / length));
                }
            }
        }
    }
}

fn rest_volume_m3(tet: &Tet) -> f32 {
    1.0 / (6.0 * tet.six_volume_reciprocal)
}

fn volume_m3([a, b, c, d]: &[crate::lanes::Row; 4]) -> f32 {
    let (u, v, w) = (difference(b, a), difference(c, a), difference(d, a));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    (cross[0] * w[0] + cross[1] * w[1] + cross[2] * w[2]) / 6.0
}
