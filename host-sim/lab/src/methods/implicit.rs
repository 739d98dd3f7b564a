//! Implicit Euler with one solve per substep (as in Baraff and Witkin 1998), but with a matrix that
//! is factored once, at rest.
//!
//! A substep is one Newton step from the inertial prediction `x^ = x + dt v`: `(M (1 + alpha
//! dt)/dt^2 + K_0) d = f(x^) - alpha M (x^ - x)/dt`, `x = x^ + d`, where f are the corotational
//! forces and `K_0` is the stiffness matrix of linear elasticity. The factor is in single precision
//! (`faer`). Contact is solved at the nodes with the same inverse, of which the columns of
//! touchable nodes are stored. The masses are the true ones, without a floor. Because the stiffness
//! is frozen, the method is stable only while the tissue is at most about twice as stiff as at
//! rest.

use palpate::stages::integrate::FASTEST_M_PER_S;
use palpate::{Fault, Params, Vector3};

use super::compliance::columns;
use super::node_contact::NodeContact;
use super::on_core::Law;
use super::{Block, Corotational, Factor, LinearElastic, RunningMethod};
use palpate_tissue::error::Error;

/// The factored matrix and the state of the nodes.
pub struct Implicit {
    law: Corotational,
    linear: LinearElastic,
    factor: Factor<f32>,
    contact: NodeContact,
    columns: Vec<Vec<Vector3<f32>>>,
    youngs_modulus_pa: f32,
    substeps: u16,
    dt_s: f32,
    /// `alpha m / (E dt)` of each node [m].
    drag_m: Vec<f32>,
    x_m: Vec<Vector3<f32>>,
    v_m_per_s: Vec<Vector3<f32>>,
    ahead_m: Vec<Vector3<f32>>,
    force: Vec<Vector3<f32>>,
    right_hand_side: Vec<f32>,
    tip_m: Option<Vector3<f32>>,
    flops: f64,
}

impl Implicit {
    /// Assembles and factors the matrix.
    pub fn new(block: &Block, params: &Params) -> Result<Self, Error> {
        let linear = LinearElastic::of(block);
        let dt_s = params.tick_s / f32::from(params.substeps);
        let rest = super::RestTet::of(block);
        let mut mass_over_e = vec![0.0_f32; linear.row.len()];
        for tet in &rest {
            let quarter = tet.volume_m3 * params.density_kg_per_m3 / (4.0 * params.youngs_modulus_pa);
            tet.node.iter().for_each(|&n| mass_over_e[n as usize] += quarter);
        }
        let inertia = (1.0 + params.node_damping_per_s * dt_s) / (dt_s * dt_s);
        let mut lower: Vec<(usize, usize, f32)> = linear.lower.iter().map(|&(r, c, v)| (r, c, v as f32)).collect();
        for (row, m) in linear.row.iter().zip(&mass_over_e) {
            lower.extend(row.iter().flat_map(|&r| (r..r + 3).map(|d| (d, d, m * inertia))));
        }
        let mut factor = Factor::new(linear.rows, &lower)?;
        let nodes = NodeContact::nodes_of(block);
        let columns = columns(&linear, &nodes, |unit| factor.solve(unit));
        let contact = NodeContact::new(block, nodes, &columns);
        let x_m: Vec<Vector3<f32>> = block.tissue.mesh.nodes_m.iter().map(|x| Vector3::from(x.map(|c| c as f32))).collect();
        Ok(Self {
            law: Corotational::new(block),
            contact,
            columns,
            youngs_modulus_pa: params.youngs_modulus_pa,
            substeps: params.substeps,
            dt_s,
            drag_m: mass_over_e.iter().map(|m| m * params.node_damping_per_s / dt_s).collect(),
            v_m_per_s: vec![Vector3::zeros(); x_m.len()],
            ahead_m: x_m.clone(),
            force: vec![Vector3::zeros(); x_m.len()],
            x_m,
            right_hand_side: vec![0.0; linear.rows],
            linear,
            factor,
            tip_m: None,
            flops: 0.0,
        })
    }

    /// Runs one substep and returns the force on the tissue over E [N/Pa].
    fn step(&mut self, tip_m: Vector3<f32>) -> Result<Vector3<f32>, Fault> {
        for ((ahead, x), v) in self.ahead_m.iter_mut().zip(&self.x_m).zip(&self.v_m_per_s) {
            *ahead = x + v * self.dt_s;
        }
        self.law.forces(&self.ahead_m, &mut self.force);
        for (n, row) in self.linear.row.iter().enumerate() {
            let Some(row) = *row else { continue };
            let f = self.force[n] - (self.ahead_m[n] - self.x_m[n]) * self.drag_m[n];
            self.right_hand_side[row..row + 3].copy_from_slice(f.as_slice());
        }
        self.factor.solve(&mut self.right_hand_side);
        for (row, ahead) in self.linear.row.iter().zip(&mut self.ahead_m) {
            if let Some(r) = *row {
                *ahead += Vector3::from_fn(|k, _| self.right_hand_side[r + k]);
            }
        }
        for (free, &n) in self.contact.free_m.iter_mut().zip(&self.contact.nodes) {
            *free = self.ahead_m[n as usize];
        }
        let load = self.contact.solve(tip_m);
        let mut pushed = 0;
        for (force, columns) in self.contact.force.iter().zip(self.columns.chunks_exact(3)) {
            if *force == Vector3::zeros() {
                continue;
            }
            pushed += 1;
            for (((x, a), b), c) in self.ahead_m.iter_mut().zip(&columns[0]).zip(&columns[1]).zip(&columns[2]) {
                *x += a * force.x + b * force.y + c * force.z;
            }
        }
        let mut fastest = 0.0_f32;
        for ((x, ahead), v) in self.x_m.iter_mut().zip(&self.ahead_m).zip(&mut self.v_m_per_s) {
            *v = (ahead - *x) / self.dt_s;
            *x = *ahead;
            fastest = if v.norm_squared() <= fastest { fastest } else { v.norm_squared() };
        }
        self.flops += (4 * self.factor.len() + 18 * pushed * self.x_m.len()) as f64 + self.contact.flops;
        if fastest <= FASTEST_M_PER_S * FASTEST_M_PER_S { Ok(load) } else { Err(Fault::Diverged) }
    }
}

impl RunningMethod for Implicit {
    fn tick(&mut self, tip_m: Vector3<f32>) -> Result<Vector3<f32>, Fault> {
        let from = self.tip_m.replace(tip_m).unwrap_or(tip_m);
        let mut load = Vector3::zeros();
        self.flops = 0.0;
        for substep in 1..=self.substeps {
            let share = f32::from(substep) / f32::from(self.substeps);
            load += self.step(from + (tip_m - from) * share)?;
        }
        let force = load * (-self.youngs_modulus_pa / f32::from(self.substeps));
        if force.iter().all(|f| f.is_finite()) { Ok(force) } else { Err(Fault::ForceNotFinite) }
    }

    fn position_m(&self, node: usize) -> Vector3<f32> {
        self.x_m[node]
    }

    fn solver_flops(&self) -> f64 {
        self.flops
    }
}
