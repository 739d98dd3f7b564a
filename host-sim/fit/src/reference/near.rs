//! The surface near the probe, where the contact is solved exactly within each Newton step.
//!
//! The energy of everything except this contact is replaced by its quadratic model. From this model
//! all unknowns are condensed out, except the displacements of the nodes near the probe; as these
//! are eliminated last, the condensed matrix is at the end of the Cholesky factor. The remaining
//! dense problem of a few hundred unknowns, including the exact energy of the contact, is minimised
//! by Newton's method with line search. This finds the touching points without another
//! factorisation of the whole matrix.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::prelude::Solve;
use faer::{Accum, Col, Mat, Side};
use nalgebra::Vector3;

use super::body::{Body, Contact};
use super::cholesky::{Cholesky, parallel};

/// Distance from the probe up to which triangles count as near [probe radii].
const MARGIN_RADII: f64 = 0.06;
const MOST_ITERATIONS: usize = 30;
/// Residual divided by the contact force at which the contact counts as solved, and the larger
/// value that suffices if a step hardly reduces the residual (1).
const TOLERANCE: f64 = 1e-11;
const ROUNDED: f64 = 1e-8;
/// Line search: smallest share of the step, share of the predicted decrease that suffices, and
/// relative difference of energies that counts as zero.
const LEAST_SHARE: f64 = 1.0 / 4096.0;
const DECREASE: f64 = 1e-4;
const ROUNDING: f64 = 1e-14;
/// Reduction of the residual with which a step is accepted whatever its energy (1).
const HALF: f64 = 0.5;
const NOT_NEAR: u32 = u32::MAX;

/// Division of the touchable surface into triangles near the probe and others.
#[derive(Default)]
pub(crate) struct Near {
    /// Triangles near the probe, as indices into those of the mesh.
    pub triangles: Vec<usize>,
    /// Other triangles that may touch the probe.
    pub others: Vec<usize>,
    /// Nodes of the triangles near the probe, ascending.
    pub nodes: Vec<u32>,
    /// Index in `nodes` of each node of the mesh, or `NOT_NEAR`.
    place: Vec<u32>,
}

impl Near {
    /// Determines the surface near a probe.
    pub fn of(body: &Body, displacement_m: &[Vector3<f64>], contact: &Contact) -> Self {
        let margin_m = MARGIN_RADII * contact.probe.radius_m;
        let (triangles, others): (Vec<usize>, Vec<usize>) =
            body.touchable.iter().partition(|t| body.least_gap_m(**t, displacement_m, contact) < margin_m);
        let mut nodes: Vec<u32> = triangles.iter().flat_map(|t| body.mesh.triangles[*t]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut place = vec![NOT_NEAR; body.mesh.nodes_m.len()];
        (0_u32..).zip(&nodes).for_each(|(at, n)| place[*n as usize] = at);
        Self { triangles, others, nodes, place }
    }

    /// Whether a triangle that is not near touches the probe.
    pub fn misses(&self, body: &Body, displacement_m: &[Vector3<f64>], contact: &Contact) -> bool {
        let all = if self.place.is_empty() { &body.touchable } else { &self.others };
        all.iter().any(|t| body.least_gap_m(*t, displacement_m, contact) < 0.0)
    }

    /// Turns a step that was computed without the contact force at its start into the one that
    /// minimises the model. Only the factor of the tangent is known.
    pub fn correct(
        &self,
        body: &Body,
        contact: &Contact,
        displacement_m: &[Vector3<f64>],
        factor: &Cholesky,
        kept: &Stiffness,
        step_m: &mut [f64],
    ) {
        let free = self.nodes.iter().flat_map(|n| (0..3).map(|k| step_m[3 * *n as usize + k])).collect::<Vec<_>>();
        let slope_m2 = -kept.of_all(&Col::from_fn(free.len(), |i| free[i]));
        let model = Model { near: self, body, contact, displacement_m, kept, slope_m2 };
        let push = model.minimise();
        let mut pushed = vec![0.0; step_m.len()];
        for (at, n) in self.nodes.iter().enumerate() {
            (0..3).for_each(|k| pushed[3 * *n as usize + k] = push[3 * at + k]);
        }
        factor.solve(&mut pushed);
        step_m.iter_mut().zip(&pushed).for_each(|(step, pushed)| *step += pushed);
    }

    /// Adds `share` times the second derivative of the contact energy to the lower triangle of a
    /// matrix of the near nodes; `curved` includes the curvature of the probe.
    fn stiffen(&self, state: &State, curved: bool, share: f64, matrix: &mut Mat<f64>) {
        let fixed = &state.body.fixed;
        state.body.each_touch(&self.triangles, state.displacement_m, state.contact, |touch| {
            let block = touch.stiffness_m(curved) * share;
            for (a, i) in touch.nodes.iter().enumerate() {
                for (b, j) in touch.nodes.iter().enumerate() {
                    let (row, column) = (self.place[*i as usize] as usize, self.place[*j as usize] as usize);
                    if row < column {
                        continue;
                    }
                    let weight = touch.shape[a] * touch.shape[b];
                    for k in 0..3 {
                        for l in 0..3 {
                            if !fixed[*i as usize][k] && !fixed[*j as usize][l] {
                                matrix[(3 * row + k, 3 * column + l)] += block[(k, l)] * weight;
                            }
                        }
                    }
                }
            }
        });
    }
}

/// A body in contact, with its displacements.
#[derive(Clone, Copy)]
pub(crate) struct State<'a> {
    pub body: &'a Body,
    pub contact: &'a Contact,
    pub displacement_m: &'a [Vector3<f64>],
}

/// Condensed stiffness of the near nodes, divided by Young's modulus.
pub(crate) struct Stiffness {
    /// Cholesky factor of the stiffness, including the contact.
    lower: Mat<f64>,
    /// Stiffness without the contact [m]; symmetric.
    matrix: Mat<f64>,
}

impl Stiffness {
    /// Computes the stiffness from a factor that ends with the near nodes, and subtracts the
    /// contact. The contact is part of the factor because tissue that is pressed hard and released
    /// has no positive definite tangent without it. Neither includes the curvature of the probe,
    /// which makes the first tangent of a step indefinite.
    pub fn of(factor: &Cholesky, near: &Near, state: Option<&State>) -> Self {
        let size = 3 * near.nodes.len();
        let lower = factor.last(size);
        let mut matrix = Mat::zeros(size, size);
        let (down, up) = (BlockStructure::TriangularLower, BlockStructure::TriangularUpper);
        matmul(&mut matrix, down, Accum::Replace, &lower, down, lower.transpose(), up, 1.0, parallel());
        if let Some(state) = state {
            near.stiffen(state, false, -1.0, &mut matrix);
        }
        for column in 0..size {
            for row in 0..column {
                matrix[(row, column)] = matrix[(column, row)];
            }
        }
        Self { lower, matrix }
    }

    /// Product of the stiffness, including the contact, and a vector.
    fn of_all(&self, step: &Col<f64>) -> Col<f64> {
        &self.lower * (self.lower.transpose() * step)
    }
}

/// Condensed quadratic model of the near nodes, with the exact energy of the contact.
struct Model<'a> {
    near: &'a Near,
    body: &'a Body,
    contact: &'a Contact,
    displacement_m: &'a [Vector3<f64>],
    kept: &'a Stiffness,
    /// Gradient of the quadratic model at its origin [m^2].
    slope_m2: Col<f64>,
}

impl Model<'_> {
    /// Force over Young's modulus on the near nodes that leads to the step of minimum energy [m^2].
    fn minimise(&self) -> Col<f64> {
        let mut there = self.displacement_m.to_vec();
        let mut step = Col::zeros(self.slope_m2.nrows());
        let mut before = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            self.put(&step, &mut there);
            let (bends, contact) = (self.forces(&step), self.slope(&there));
            let slope = &bends + &contact;
            let (residual, force) = (slope.norm_l2(), contact.norm_l2().max(bends.norm_l2()));
            if residual <= TOLERANCE * force || (residual <= ROUNDED * force && residual > HALF * before) {
                break;
            }
            before = residual;
            let Some(way) = self.way(&there, &slope) else { break };
            let descent = slope.transpose() * &way;
            let energy = self.energy(&step, &there);
            let mut share = 1.0;
            let next = loop {
                let next = &step + &way * share;
                self.put(&next, &mut there);
                let falls = self.energy(&next, &there) <= energy + ROUNDING * energy.abs() + DECREASE * share * descent;
                // close to the minimum, rounding hides the remaining decrease
                if falls || (self.forces(&next) + self.slope(&there)).norm_l2() < HALF * residual {
                    break Some(next);
                }
                share *= 0.5;
                if share < LEAST_SHARE {
                    break None;
                }
            };
            let Some(next) = next else { break };
            step = next;
        }
        self.kept.of_all(&step) + &self.slope_m2
    }

    /// Gradient of the quadratic model after `step`.
    fn forces(&self, step: &Col<f64>) -> Col<f64> {
        &self.kept.matrix * step + &self.slope_m2
    }

    /// Writes the displacements of the mesh after a step of the near nodes into `there`.
    fn put(&self, step: &Col<f64>, there: &mut [Vector3<f64>]) {
        for (at, n) in self.near.nodes.iter().enumerate() {
            let n = *n as usize;
            there[n] = self.displacement_m[n] + Vector3::from_fn(|k, _| step[3 * at + k]);
        }
    }

    fn energy(&self, step: &Col<f64>, there: &[Vector3<f64>]) -> f64 {
        let bends = &self.kept.matrix * step * 0.5 + &self.slope_m2;
        step.transpose() * bends + self.body.contact_energy_m3(&self.near.triangles, there, self.contact)
    }

    /// Gradient of the contact energy.
    fn slope(&self, there: &[Vector3<f64>]) -> Col<f64> {
        let mut slope = Col::zeros(self.slope_m2.nrows());
        self.body.each_touch(&self.near.triangles, there, self.contact, |touch| {
            for (a, n) in touch.nodes.iter().enumerate() {
                let push = touch.push_m2() * touch.shape[a];
                for k in 0..3 {
                    if !self.body.fixed[*n as usize][k] {
                        slope[3 * self.near.place[*n as usize] as usize + k] += push[k];
                    }
                }
            }
        });
        slope
    }

    /// Newton step. If the matrix would be indefinite, the curvature of the probe is left out, and
    /// if that does not suffice, the contact that is part of the factor is added.
    fn way(&self, there: &[Vector3<f64>], slope: &Col<f64>) -> Option<Col<f64>> {
        let state = State { body: self.body, contact: self.contact, displacement_m: there };
        let under = |mut matrix: Mat<f64>, curved: bool| {
            self.near.stiffen(&state, curved, 1.0, &mut matrix);
            Some(-matrix.llt(Side::Lower).ok()?.solve(slope))
        };
        let own = || self.kept.matrix.clone();
        let all = || &self.kept.lower * self.kept.lower.transpose();
        under(own(), true).or_else(|| under(own(), false)).or_else(|| under(all(), false))
    }
}
