//! A damper parallel to every spring, each with its own constant (paper 000, eqs 5 and 12; the
//! damper of paper 004, eq 1).
//!
//! * in: positions, velocities
//! * out: adds to the forces on the nodes
//! * cost: about as much as the spring forces
//! * failures: none

use palpate::{Model, Params, State};

/// Damping constants of the springs.
#[derive(Clone, Copy, Debug)]
pub struct Dampers<'a> {
    /// Damping constant over E [m s], in the order of the model's springs, shape \[springs\].
    pub damping_m_s: &'a [f32],
}

/// Law by which the damping constant of a spring follows from its stiffness k, masses and length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DampingLaw {
    /// `2 sqrt(k (m_i + m_j)) / l0` with l0 in metres: (12) as printed. Its unit is kg/(s m), not
    /// kg/s.
    PrintedMetres,
    /// The printed equation with l0 in millimetres, as if the whole model were in millimetres.
    PrintedMillimetres,
    /// `2 sqrt(k (m_i + m_j))`: without the length, the unit is correct.
    WithoutLength,
    /// A share of `2 sqrt(k m_i m_j / (m_i + m_j))`, the critical damping of two masses on a
    /// spring. At 1 it is the corrected form of (12).
    Critical(f32),
    /// One constant for all springs [N s/m] (paper 004, eq 1).
    Constant(f32),
}

impl DampingLaw {
    /// Writes the damping constant of every spring over E [m s] into `damping_m_s`, shape
    /// \[springs\]. Masses are those of (10), without a floor.
    pub fn fill(self, model: &Model, params: &Params, damping_m_s: &mut [f32]) {
        let e = params.youngs_modulus_pa;
        let mass_kg = |n: u16| model.nodes.get(usize::from(n)).map_or(0.0, |node| params.density_kg_per_m3 * node.volume_m3);
        for (d, s) in damping_m_s.iter_mut().zip(model.springs) {
            let (k, rest_m) = (e * s.k, s.k_rest / s.k);
            let (a, b) = (mass_kg(s.i), mass_kg(s.j));
            let printed = 2.0 * (k * (a + b)).sqrt();
            *d = match self {
                Self::PrintedMetres => printed / rest_m,
                Self::PrintedMillimetres => printed / (1e3 * rest_m),
                Self::WithoutLength => printed,
                Self::Critical(share) => share * 2.0 * (k * (a * b / (a + b))).sqrt(),
                Self::Constant(constant) => constant,
            } / e;
        }
    }
}

impl Dampers<'_> {
    /// Adds the damping forces over E [N/Pa]. If the ends approach each other, the force on both is
    /// outward, as in (5); (1) of paper 004 with the signs that survive in its text would drive the
    /// motion instead of damping it.
    pub fn resist(&self, model: &Model, state: &mut State) {
        for (s, &constant) in model.springs.iter().zip(self.damping_m_s) {
            let [i, j] = [s.i, s.j].map(usize::from);
            let [a, b] = [i, j].map(|n| state.nodes()[n]);
            let (d, v) = (b.position_m() - a.position_m(), b.velocity_m_per_s() - a.velocity_m_per_s());
            let (square, opening) = (d.dot(&d), d.dot(&v));
            if square == 0.0 {
                continue;
            }
            let force = d * (constant * opening / square);
            state.add_force(i, force);
            state.add_force(j, -force);
        }
    }
}
