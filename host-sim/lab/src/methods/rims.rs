//! Rim treatments other than springs, on the core's tick: the dense condensed outside, a low-rank
//! form of it, and modes to which the rim is slaved.
//!
//! The model on which they run has no rim springs of its own; the mass floor of its rim nodes
//! includes the stiffness that is attached here. Dense and low-rank rims add the effect of their
//! force to the velocities after each substep; with the force of the next substep this is one step
//! of symplectic Euler. Modes have the masses `Phi^T m Phi`, where m are the floored masses of the
//! rim nodes: a system that is stable at a step remains stable when it is restricted to a subspace.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use palpate::method::Method;
use palpate::{Model, Params, State, Tuned, Vector3};

use super::on_core::steps;
use crate::far_field::rim_method::LowRank;

/// The rim nodes of a running patch.
#[derive(Debug)]
struct RimNodes {
    node: Vec<usize>,
    rest_m: Vec<Vector3<f32>>,
    /// Change of a node's velocity per force over E [m/s per N/Pa].
    step: Vec<f32>,
    /// Displacements of the rim nodes [m], shape [3 rim nodes].
    moved_m: Vec<f32>,
    /// Forces on the rim nodes over E [N/Pa], shape [3 rim nodes].
    force: Vec<f32>,
}

impl RimNodes {
    fn of(model: &Model, tuned: &Tuned, params: &Params, node: &[usize]) -> Self {
        let all = steps(tuned, params, model.nodes.len());
        Self {
            node: node.to_vec(),
            rest_m: node.iter().map(|n| model.nodes[*n].rest_m.into()).collect(),
            step: node.iter().map(|n| all[*n]).collect(),
            moved_m: vec![0.0; 3 * node.len()],
            force: vec![0.0; 3 * node.len()],
        }
    }

    fn look(&mut self, state: &State) {
        let nodes = state.nodes();
        for ((moved, n), rest) in self.moved_m.chunks_exact_mut(3).zip(&self.node).zip(&self.rest_m) {
            moved.copy_from_slice((nodes[*n].position_m() - rest).as_slice());
        }
    }

    fn kick(&self, state: &mut State) {
        for ((f, n), step) in self.force.chunks_exact(3).zip(&self.node).zip(&self.step) {
            let node = state.nodes()[*n];
            let kick = Vector3::new(f[0], f[1], f[2]) * *step;
            state.place(*n, node.position_m(), node.velocity_m_per_s() + kick);
        }
    }
}

/// The matrix in row-major order and single precision.
fn flat(m: &Mat<f64>) -> Vec<f32> {
    (0..m.nrows()).flat_map(|r| (0..m.ncols()).map(move |c| m[(r, c)] as f32)).collect()
}

/// The rim coupled by the whole condensed matrix.
#[derive(Debug)]
pub struct DenseRim {
    rim: RimNodes,
    stiffness_m: Vec<f32>,
}

impl DenseRim {
    /// Couples the rim nodes `node` by `stiffness_m`, the stiffness over E, shape [3 rim nodes][3
    /// rim nodes].
    #[must_use]
    pub fn new(model: &Model, tuned: &Tuned, params: &Params, node: &[usize], stiffness_m: &Mat<f64>) -> Self {
        Self { rim: RimNodes::of(model, tuned, params, node), stiffness_m: flat(stiffness_m) }
    }

    /// Floating-point operations per substep, and bytes of constants read per substep, for this
    /// many rim nodes.
    #[must_use]
    pub fn cost(rim_nodes: usize) -> (usize, usize) {
        (18 * rim_nodes * rim_nodes, 36 * rim_nodes * rim_nodes)
    }
}

impl Method for DenseRim {
    fn correct(&mut self, _: &Model, _: &Tuned, state: &mut State) {
        self.rim.look(state);
        let RimNodes { moved_m, force, .. } = &mut self.rim;
        for (f, row) in force.iter_mut().zip(self.stiffness_m.chunks_exact(moved_m.len().max(1))) {
            *f = -row.iter().zip(moved_m.iter()).map(|(s, u)| s * u).sum::<f32>();
        }
        self.rim.kick(state);
    }
}

/// The rim coupled by blocks on the diagonal minus a matrix of low rank.
#[derive(Debug)]
pub struct LowRankRim {
    rim: RimNodes,
    blocks_m: Vec<[[f32; 3]; 3]>,
    /// Row-major, shape [3 rim nodes][q].
    factor: Vec<f32>,
    along: Vec<f32>,
}

impl LowRankRim {
    /// Couples the rim nodes `node` by `stiffness`.
    #[must_use]
    pub fn new(model: &Model, tuned: &Tuned, params: &Params, node: &[usize], stiffness: &LowRank) -> Self {
        Self {
            rim: RimNodes::of(model, tuned, params, node),
            blocks_m: stiffness.blocks.iter().map(|b| b.map(|row| row.map(|v| v as f32))).collect(),
            factor: flat(&stiffness.factor),
            along: vec![0.0; stiffness.factor.ncols()],
        }
    }

    /// Floating-point operations per substep, and bytes of constants read per substep, for this
    /// many rim nodes and a rank `q`.
    #[must_use]
    pub fn cost(rim_nodes: usize, q: usize) -> (usize, usize) {
        (rim_nodes * (18 + 12 * q), 4 * rim_nodes * (9 + 3 * q))
    }
}

impl Method for LowRankRim {
    fn correct(&mut self, _: &Model, _: &Tuned, state: &mut State) {
        self.rim.look(state);
        let q = self.along.len().max(1);
        self.along.fill(0.0);
        for (row, u) in self.factor.chunks_exact(q).zip(&self.rim.moved_m) {
            self.along.iter_mut().zip(row).for_each(|(a, w)| *a += w * u);
        }
        let rows = self.factor.chunks_exact(q);
        let own = self.blocks_m.iter().zip(self.rim.moved_m.chunks_exact(3));
        let held = own.flat_map(|(block, u)| block.map(|b| b[0] * u[0] + b[1] * u[1] + b[2] * u[2]));
        for ((f, row), held) in self.rim.force.iter_mut().zip(rows).zip(held) {
            *f = row.iter().zip(&self.along).map(|(w, a)| w * a).sum::<f32>() - held;
        }
        self.rim.kick(state);
    }
}

/// A rim that moves only in a few shapes, which have their own inertia.
#[derive(Debug)]
pub struct ModeRim {
    rim: RimNodes,
    /// Row-major, shape [3 rim nodes][q].
    shapes: Vec<f32>,
    /// Change of the modes' velocities per substep and per force over E on the rim, shape [3 rim
    /// nodes][q].
    pushes: Vec<f32>,
    /// Decrease of the modes' velocities per substep and per displacement of the modes, shape
    /// [q][q].
    holds: Vec<f32>,
    place_m: Vec<f32>,
    speed: Vec<f32>,
    gain: Vec<f32>,
    keep: f32,
    substep_s: f32,
}

impl ModeRim {
    /// Restricts the rim nodes `node` to the orthonormal `shapes`, shape [3 rim nodes][q], held by
    /// the stiffness `stiffness_m` over E of the outside. `None` if the mass matrix of the shapes
    /// is not positive definite.
    #[must_use]
    pub fn new(
        model: &Model,
        tuned: &Tuned,
        params: &Params,
        node: &[usize],
        shapes: &Mat<f64>,
        stiffness_m: &Mat<f64>,
    ) -> Option<Self> {
        let substep_s = params.tick_s / f32::from(params.substeps);
        let mass = |r: usize| tuned.mass_kg(node[r / 3]).map_or(f64::INFINITY, f64::from);
        let inertia = Mat::from_fn(shapes.ncols(), shapes.ncols(), |a, b| {
            (0..shapes.nrows()).map(|r| shapes[(r, a)] * mass(r) * shapes[(r, b)]).sum::<f64>()
        });
        let by = f64::from(params.youngs_modulus_pa) * f64::from(substep_s);
        let solver = inertia.llt(Side::Lower).ok()?;
        let pushes = solver.solve(shapes.transpose().to_owned()) * faer::Scale(by);
        let holds = &pushes * stiffness_m * shapes;
        let still = vec![0.0; shapes.ncols()];
        Some(Self {
            rim: RimNodes::of(model, tuned, params, node),
            shapes: flat(shapes),
            pushes: flat(&pushes.transpose().to_owned()),
            holds: flat(&holds),
            place_m: still.clone(),
            speed: still.clone(),
            gain: still,
            keep: 1.0 - params.node_damping_per_s * substep_s,
            substep_s,
        })
    }

    /// Floating-point operations per substep, and bytes of constants read per substep, for this
    /// many rim nodes and `q` modes.
    #[must_use]
    pub fn cost(rim_nodes: usize, q: usize) -> (usize, usize) {
        // the velocities of the rim are differences of its displacements, so one product gives both
        (12 * rim_nodes * q + 2 * q * q, 4 * (6 * rim_nodes * q + q * q))
    }
}

impl Method for ModeRim {
    fn correct(&mut self, _: &Model, _: &Tuned, state: &mut State) {
        let q = self.place_m.len().max(1);
        for (gain, row) in self.gain.iter_mut().zip(self.holds.chunks_exact(q)) {
            *gain = -row.iter().zip(&self.place_m).map(|(h, p)| h * p).sum::<f32>();
        }
        for (n, rows) in self.rim.node.iter().zip(self.pushes.chunks_exact(3 * q)) {
            let force = state.nodes()[*n].force_over_modulus();
            for (row, f) in rows.chunks_exact(q).zip(force.iter()) {
                self.gain.iter_mut().zip(row).for_each(|(gain, p)| *gain += p * f);
            }
        }
        for ((speed, place), gain) in self.speed.iter_mut().zip(&mut self.place_m).zip(&self.gain) {
            *speed = *speed * self.keep + gain;
            *place += *speed * self.substep_s;
        }
        let per_s = 1.0 / self.substep_s;
        let RimNodes { node, rest_m, moved_m, .. } = &mut self.rim;
        for (((n, rest), rows), before) in
            node.iter().zip(rest_m.iter()).zip(self.shapes.chunks_exact(3 * q)).zip(moved_m.chunks_exact_mut(3))
        {
            let moved = Vector3::from_fn(|c, _| rows[c * q..(c + 1) * q].iter().zip(&self.place_m).map(|(s, p)| s * p).sum());
            let was = Vector3::new(before[0], before[1], before[2]);
            before.copy_from_slice(moved.as_slice());
            state.place(*n, rest + moved, (moved - was) * per_s);
        }
    }
}
