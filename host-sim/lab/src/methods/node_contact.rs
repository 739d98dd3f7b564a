//! Frictionless unilateral contact at the nodes, given their compliance: Signorini's conditions are
//! solved by projected Gauss-Seidel.
//!
//! `gap_i = (x_i - c) . n_i - R + sum_j D_ij lambda_j >= 0`, `lambda >= 0`, and one of the two is
//! zero; `D_ij = n_i^T W_ij n_j`. The normals are those at the positions of the previous solution,
//! and are updated once per solve. The forces of the last tick are the first guess.

use palpate::{Probe, Vector3};

use super::Block;

/// Number of rounds, each of which recomputes the normals.
const ROUNDS: usize = 2;
/// Largest number of Gauss-Seidel sweeps in a round.
const SWEEPS: usize = 40;
/// Change of the gaps in a sweep below which the sweeps end [m].
const SETTLED_M: f32 = 1e-8;
/// Distance from the probe's surface beyond which nodes are left out of a solve [probe radii].
const NEAR: f32 = 0.25;
/// Distance from the site within which surface nodes count as touchable [probe radii].
const REACH: f64 = 1.25;

/// The touchable nodes and their compliance.
pub(super) struct NodeContact {
    probe: Probe,
    /// Indices of the touchable nodes in the mesh.
    pub nodes: Vec<u32>,
    /// Compliance between the touchable nodes, times E [1/m], shape \[3 nodes\]\[3 nodes\].
    w: Vec<f32>,
    /// Position of each touchable node without contact [m]; the caller fills it before each solve.
    pub free_m: Vec<Vector3<f32>>,
    /// Force on each touchable node over E [N/Pa].
    pub force: Vec<Vector3<f32>>,
    lambda: Vec<f32>,
    normal: Vec<Vector3<f32>>,
    active: Vec<usize>,
    gap_m: Vec<f32>,
    d: Vec<f32>,
    /// Floating-point operations of the last solve.
    pub flops: f64,
}

impl NodeContact {
    /// Surface nodes near the site, whose compliance [`Self::new`] then needs.
    pub fn nodes_of(block: &Block) -> Vec<u32> {
        let site = Vector3::from(block.tissue.site_m);
        let reach = REACH * f64::from(block.params.probe.radius_m);
        let surface = palpate_tissue::mesh::surface::surface(&block.tissue.mesh.tets);
        let mut nodes: Vec<u32> = surface.into_iter().flatten().collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes.retain(|&n| {
            let x = Vector3::from(block.tissue.mesh.nodes_m[n as usize]) - site;
            x.norm() <= reach
        });
        nodes
    }

    /// Creates the contact of `nodes`; `columns[3 i + a]` is the displacement of all nodes per
    /// force over E on `nodes[i]` along axis a [1/m].
    pub fn new(block: &Block, nodes: Vec<u32>, columns: &[Vec<Vector3<f32>>]) -> Self {
        let count = nodes.len();
        let mut w = vec![0.0; 9 * count * count];
        for (j, column) in columns.iter().enumerate() {
            for (i, &n) in nodes.iter().enumerate() {
                for a in 0..3 {
                    w[(3 * i + a) * 3 * count + j] = column[n as usize][a];
                }
            }
        }
        Self {
            probe: block.params.probe,
            w,
            free_m: vec![Vector3::zeros(); count],
            force: vec![Vector3::zeros(); count],
            lambda: vec![0.0; count],
            normal: vec![block.params.probe.axis; count],
            active: Vec::with_capacity(count),
            gap_m: vec![0.0; count],
            d: vec![0.0; count * count],
            nodes,
            flops: 0.0,
        }
    }

    /// Solves the contact and returns the total force on the tissue over E [N/Pa].
    pub fn solve(&mut self, tip_m: Vector3<f32>) -> Vector3<f32> {
        let centre = tip_m + self.probe.axis * self.probe.radius_m;
        self.flops = 0.0;
        for _ in 0..ROUNDS {
            self.look(centre);
            self.reduce();
            self.sweep();
            for (i, f) in self.force.iter_mut().enumerate() {
                *f = self.normal[i] * self.lambda[i];
            }
        }
        self.force.iter().sum()
    }

    /// Finds the nodes near the probe, their normals, and their gaps without contact.
    fn look(&mut self, centre: Vector3<f32>) {
        let count = self.nodes.len();
        let radius = self.probe.radius_m;
        let touching = self.active.len();
        let mut position = std::mem::take(&mut self.free_m);
        for (i, x) in position.iter_mut().enumerate() {
            let free = *x;
            for &j in self.active.iter().filter(|&&j| self.lambda[j] > 0.0) {
                *x += self.times(i, j, count, &self.force[j]);
            }
            let mut away = *x - centre;
            let along = away.dot(&self.probe.axis);
            if along > 0.0 {
                away -= self.probe.axis * along;
            }
            let length = away.norm();
            self.normal[i] = if length > 0.0 { away / length } else { -self.probe.axis };
            let mut from_centre = free - centre;
            if along > 0.0 {
                from_centre -= self.probe.axis * from_centre.dot(&self.probe.axis);
            }
            self.gap_m[i] = from_centre.dot(&self.normal[i]) - radius;
            // an infinite gap excludes a node from the solve
            if length > (1.0 + NEAR) * radius {
                self.gap_m[i] = f32::INFINITY;
                self.lambda[i] = 0.0;
            }
            *x = free;
        }
        self.free_m = position;
        self.active.clear();
        self.active.extend((0..count).filter(|&i| self.gap_m[i].is_finite()));
        self.flops += (count * touching * 18) as f64;
    }

    /// Returns `W_ij f`.
    fn times(&self, i: usize, j: usize, count: usize, f: &Vector3<f32>) -> Vector3<f32> {
        Vector3::from_fn(|a, _| {
            let row = (3 * i + a) * 3 * count + 3 * j;
            self.w[row] * f.x + self.w[row + 1] * f.y + self.w[row + 2] * f.z
        })
    }

    /// Computes the compliance `D_ij` along the normals of the active nodes.
    fn reduce(&mut self) {
        let (count, active) = (self.nodes.len(), self.active.len());
        for (r, &i) in self.active.iter().enumerate() {
            for (c, &j) in self.active.iter().enumerate().skip(r) {
                let d = self.times(i, j, count, &self.normal[j]).dot(&self.normal[i]);
                self.d[r * active + c] = d;
                self.d[c * active + r] = d;
            }
        }
        self.flops += (active * active * 10) as f64;
    }

    fn sweep(&mut self) {
        let active = self.active.len();
        for _ in 0..SWEEPS {
            let mut furthest = 0.0_f32;
            for (r, &i) in self.active.iter().enumerate() {
                let row = &self.d[r * active..(r + 1) * active];
                let reached: f32 = row.iter().zip(&self.active).map(|(d, &j)| d * self.lambda[j]).sum();
                let wanted = self.lambda[i] - (self.gap_m[i] + reached) / row[r];
                let wanted = if wanted > 0.0 { wanted } else { 0.0 };
                furthest = furthest.max((wanted - self.lambda[i]).abs() * row[r]);
                self.lambda[i] = wanted;
            }
            self.flops += (active * active * 2) as f64;
            if furthest < SETTLED_M {
                break;
            }
        }
    }
}
