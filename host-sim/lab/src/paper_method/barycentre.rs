//! Volume force of paper 004, eq (2): each corner of a tet is pushed along the line from the tet's
//! barycentre.
//!
//! `F_i = -sum_w c (V_w - V_w0) (p_i - b_w)/|p_i - b_w|`. The unit vectors do not add up to zero,
//! so the tet exerts a net force on itself and momentum is not conserved. The paper prints no
//! coefficient c; without one the unit is m^3. The force is implemented as the paper has it; the
//! product's `volume` is the gradient of an energy.
//!
//! * in: positions
//! * out: adds to the forces on the nodes
//! * cost: about two springs per corner
//! * failures: none

use palpate::{Model, State, Tet, Tuned, Vector3};

/// Volume force of (2).
#[derive(Clone, Copy, Debug)]
pub struct BarycentreForce {
    /// Coefficient c [Pa/m].
    pub coefficient_pa_per_m: f32,
}

impl BarycentreForce {
    /// Adds the forces over E [N/Pa].
    pub fn push(&self, model: &Model, tuned: &Tuned, state: &mut State) {
        let over_modulus = self.coefficient_pa_per_m / tuned.youngs_modulus_pa();
        for tet in model.tets {
            let corners = tet.node.map(|n| state.nodes()[usize::from(n)].position_m());
            let barycentre: Vector3<f32> = corners.iter().map(|x| x * 0.25).sum();
            let growth_m3 = volume_m3(&corners) - rest_volume_m3(tet);
            for (n, x) in tet.node.into_iter().zip(&corners) {
                let out = x - barycentre;
                let length = out.dot(&out).sqrt();
                if length > 0.0 {
                    state.add_force(usize::from(n), out * (-over_modulus * growth_m3 / length));
                }
            }
        }
    }
}

fn rest_volume_m3(tet: &Tet) -> f32 {
    1.0 / (6.0 * tet.six_volume_reciprocal)
}

fn volume_m3([a, b, c, d]: &[Vector3<f32>; 4]) -> f32 {
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
}
