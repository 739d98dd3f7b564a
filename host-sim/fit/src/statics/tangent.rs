//! The tangent stiffness over E as a sparse matrix, and its Cholesky factor.

use std::collections::BTreeSet;

use faer::sparse::linalg::LltError;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Mat, MatMut, Side};
use nalgebra::Matrix3;

use super::{Statics, Vector, elastic};

/// Positions of the free nodes' blocks in the matrix, of which the lower triangle is stored column
/// by column.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    symbolic: SymbolicSparseColMat<usize>,
    factor: SymbolicLlt<usize>,
    /// Rows of every column of blocks, as indices of free nodes from the diagonal down.
    rows: Vec<Vec<usize>>,
    /// Index of the first value of every column of blocks.
    start: Vec<usize>,
    /// Nodes around each node, including the node itself.
    stars: Vec<Vec<usize>>,
    /// Blocks of all pairs of nodes around a node, shape \[nodes\] [star * star].
    star_slots: Vec<Vec<Slot>>,
    /// Diagonal blocks of the two ends of a spring, and the block between them, shape \[springs\].
    spring_slots: Vec<[Slot; 3]>,
    /// Blocks of all pairs of nodes of a tet, shape \[tets\].
    tet_slots: Vec<[[Slot; 4]; 4]>,
    /// Index of each node of a tet in the star of each other node, shape \[tets\].
    tet_in_star: Vec<[[usize; 4]; 4]>,
}

/// Position of a block among the values; [`Slot::NONE`] above the diagonal and at anchors.
#[derive(Clone, Copy, Debug)]
struct Slot {
    first: usize,
    /// Number of values from one column to the next.
    pitch: usize,
}

impl Slot {
    const NONE: Self = Self { first: 0, pitch: 0 };

    fn is_none(self) -> bool {
        self.pitch == 0
    }

    fn add(self, values: &mut [f64], block: &Matrix3<f64>) {
        if self.is_none() {
            return;
        }
        for (c, column) in block.as_slice().chunks_exact(3).enumerate() {
            let first = self.first + c * self.pitch;
            values[first..first + 3].iter_mut().zip(column).for_each(|(v, b)| *v += b);
        }
    }

    /// Adds the outer product of two vectors.
    fn add_outer(self, values: &mut [f64], a: &Vector, b: &Vector) {
        if self.is_none() {
            return;
        }
        for (c, b) in b.iter().enumerate() {
            let first = self.first + c * self.pitch;
            values[first..first + 3].iter_mut().zip(a.iter()).for_each(|(v, a)| *v += a * b);
        }
    }
}

impl Pattern {
    /// Pattern of all pairs of nodes around a common node, which the nodal volume couples; `None`
    /// if the mesh is too large to be analysed.
    pub fn of(statics: &Statics) -> Option<Self> {
        let mut stars: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); statics.rest_m.len()];
        for t in &statics.tets {
            t.node.iter().for_each(|&n| stars[n].extend(t.node));
        }
        let mut below: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); statics.free_nodes()];
        for star in &stars {
            let free: Vec<usize> = star.iter().filter_map(|&n| statics.free[n]).collect();
            for &a in &free {
                below[a].extend(free.iter().filter(|&&b| b >= a));
            }
        }
        if let Some(rim) = &statics.rim {
            let free: Vec<usize> = rim.node.iter().filter_map(|&n| statics.free[n]).collect();
            for &a in &free {
                below[a].extend(free.iter().filter(|&&b| b >= a));
            }
        }
        let rows: Vec<Vec<usize>> = below.into_iter().map(|r| r.into_iter().collect()).collect();
        let mut start = Vec::with_capacity(rows.len());
        let (mut columns, mut indices) = (vec![0], Vec::new());
        for column in &rows {
            start.push(indices.len());
            for _ in 0..3 {
                indices.extend(column.iter().flat_map(|&i| [3 * i, 3 * i + 1, 3 * i + 2]));
                columns.push(indices.len());
            }
        }
        let size = 3 * rows.len();
        let symbolic = SymbolicSparseColMat::new_checked(size, size, columns, None, indices);
        let factor = SymbolicLlt::try_new(symbolic.as_ref(), Side::Lower).ok()?;
        let stars: Vec<Vec<usize>> = stars.into_iter().map(|s| s.into_iter().collect()).collect();
        let (star_slots, spring_slots, tet_slots, tet_in_star) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut pattern = Self { symbolic, factor, rows, start, stars, star_slots, spring_slots, tet_slots, tet_in_star };
        pattern.find_slots(statics);
        Some(pattern)
    }

    fn find_slots(&mut self, statics: &Statics) {
        let slot = |a: usize, b: usize| match (statics.free[a], statics.free[b]) {
            (Some(i), Some(j)) => self.slot(i, j),
            _ => Slot::NONE,
        };
        let of_star = |star: &Vec<usize>| star.iter().flat_map(|&a| star.iter().map(move |&b| slot(a, b))).collect();
        let star_slots = self.stars.iter().map(of_star).collect();
        let between = |[a, b]: [usize; 2]| if statics.free[a] > statics.free[b] { slot(a, b) } else { slot(b, a) };
        let spring_slots =
            statics.springs.iter().map(|s| [slot(s.node[0], s.node[0]), slot(s.node[1], s.node[1]), between(s.node)]).collect();
        let tet_slots = statics.tets.iter().map(|t| t.node.map(|a| t.node.map(|b| slot(a, b)))).collect();
        let at = |a: usize, b: usize| self.stars[a].binary_search(&b).unwrap_or_default();
        let tet_in_star = statics.tets.iter().map(|t| t.node.map(|a| t.node.map(|b| at(a, b)))).collect();
        (self.star_slots, self.spring_slots) = (star_slots, spring_slots);
        (self.tet_slots, self.tet_in_star) = (tet_slots, tet_in_star);
    }

    /// Slot of the block at row `i` and column `j` (indices of free nodes).
    fn slot(&self, i: usize, j: usize) -> Slot {
        if i < j {
            return Slot::NONE;
        }
        let rows = &self.rows[j];
        let Ok(at) = rows.binary_search(&i) else { return Slot::NONE };
        Slot { first: self.start[j] + 3 * at, pitch: 3 * rows.len() }
    }

    /// Adds a block at row `i` and column `j` (indices of free nodes). A block above the diagonal
    /// is skipped, because its transpose is added below the diagonal.
    fn add(&self, values: &mut [f64], i: usize, j: usize, block: &Matrix3<f64>) {
        self.slot(i, j).add(values, block);
    }
}

/// A factored tangent.
#[derive(Clone, Debug)]
pub(super) struct Factor(Llt<usize, f64>);

impl Factor {
    /// Solves in place for free degrees of freedom.
    pub fn solve(&self, right: MatMut<f64>) {
        use faer::linalg::solvers::SolveCore;
        self.0.solve_in_place_with_conj(faer::Conj::No, right);
    }

    /// Solves for vectors on all nodes; the solution is zero at anchors.
    pub fn solve_nodes(&self, statics: &Statics, right: &[Vector]) -> Vec<Vector> {
        let mut column = Mat::zeros(3 * statics.free_nodes(), 1);
        for (slot, v) in statics.free.iter().zip(right) {
            if let Some(at) = slot {
                (0..3).for_each(|k| column[(3 * at + k, 0)] = v[k]);
            }
        }
        self.solve(column.as_mut());
        let on = |slot: &Option<usize>| slot.map_or(Vector::zeros(), |at| Vector::from_fn(|k, _| column[(3 * at + k, 0)]));
        statics.free.iter().map(on).collect()
    }
}

impl Statics {
    /// Factors the tangent of the energy over E at `x`, including the probe; `shift` times the
    /// diagonal is added to it.
    pub(super) fn factor(&self, pattern: &Pattern, x: &[Vector], tip_m: Option<Vector>, shift: f64) -> Result<Factor, LltError> {
        self.factor_with(pattern, x, tip_m, &[], shift)
    }

    /// Like `factor`, with additional supports at points of surface triangles, given by corners,
    /// weights and stiffness over E [m].
    pub(super) fn factor_with(
        &self,
        pattern: &Pattern,
        x: &[Vector],
        tip_m: Option<Vector>,
        held: &[([usize; 3], [f64; 3], Matrix3<f64>)],
        shift: f64,
    ) -> Result<Factor, LltError> {
        let mut values = vec![0.0; pattern.symbolic.as_ref().row_idx().len()];
        let add = |values: &mut [f64], a: usize, b: usize, block: &Matrix3<f64>| {
            if let (Some(i), Some(j)) = (self.free[a], self.free[b]) {
                pattern.add(values, i, j, block);
            }
        };
        let pushes = tip_m.map_or_else(Vec::new, |tip_m| self.pushes(x, tip_m));
        let stiffer = self.stiffer(x, &pushes);
        for (s, [first, second, between]) in self.springs.iter().zip(&pattern.spring_slots) {
            let mut block = self.pull(s, x).curvature();
            if let Some(stiffer) = &stiffer {
                block *= stiffer.of_spring(s.node);
            }
            first.add(&mut values, &block);
            second.add(&mut values, &block);
            between.add(&mut values, &-block);
        }
        if self.volume_acts {
            self.add_volume(pattern, x, &mut values);
        }
        if let Some(rim) = &self.rim {
            for (i, &a) in rim.node.iter().enumerate() {
                for (j, &b) in rim.node.iter().enumerate() {
                    add(&mut values, a, b, &rim.block(i, j));
                }
            }
        }
        if let Some(stiffer) = &stiffer {
            self.add_steeper(stiffer, &pattern.stars, x, &pushes, &mut |a, b, block| add(&mut values, a, b, block));
        }
        let pushed = pushes.iter().map(|p| {
            let node = self.triangles[p.triangle].node;
            let factor = stiffer.as_ref().map_or(1.0, |stiffer| stiffer.of_point(node, p.weights));
            (node, p.weights, p.curvature * factor)
        });
        for (node, weights, curvature) in pushed.chain(held.iter().copied()) {
            for (a, wa) in node.iter().zip(weights) {
                for (b, wb) in node.iter().zip(weights) {
                    add(&mut values, *a, *b, &(curvature * (wa * wb)));
                }
            }
        }
        if shift > 0.0 {
            for (j, rows) in pattern.rows.iter().enumerate() {
                (0..3).for_each(|c| values[pattern.start[j] + 3 * c * rows.len() + c] *= 1.0 + shift);
            }
        }
        let matrix = SparseColMatRef::new(pattern.symbolic.as_ref(), &values);
        Llt::try_new_with_symbolic(pattern.factor.clone(), matrix, Side::Lower).map(Factor)
    }

    fn add_volume(&self, pattern: &Pattern, x: &[Vector], values: &mut [f64]) {
        let shapes: Vec<elastic::TetGeometry> = self.tets.iter().map(|t| elastic::geometry(t, x)).collect();
        let mut around = vec![0.0; x.len()];
        for (t, shape) in self.tets.iter().zip(&shapes) {
            t.node.iter().for_each(|&n| around[n] += shape.six_volume);
        }
        let nodal = self.node_pressures(&around);
        // gradients of each node's volume with respect to the nodes around it
        let mut slopes: Vec<Vec<Vector>> = pattern.stars.iter().map(|s| vec![Vector::zeros(); s.len()]).collect();
        for (n, (t, shape)) in self.tets.iter().zip(&shapes).enumerate() {
            let (own, own_slope) = elastic::own_pressure(t, shape.six_volume, self.compensation_acts);
            let pressure = own + t.node.iter().map(|&n| nodal[n].0).sum::<f64>();
            let between = shape.between();
            for (i, &a) in t.node.iter().enumerate() {
                for j in 0..4 {
                    let slot = pattern.tet_slots[n][i][j];
                    if !slot.is_none() {
                        let outer = shape.gradient[i] * shape.gradient[j].transpose();
                        slot.add(values, &(between[i][j] * pressure + outer * own_slope));
                    }
                    slopes[a][pattern.tet_in_star[n][i][j]] += shape.gradient[j];
                }
            }
        }
        for (n, (slots, slopes)) in pattern.star_slots.iter().zip(&slopes).enumerate() {
            for (slots, ga) in slots.chunks_exact(slopes.len()).zip(slopes) {
                let scaled = ga * nodal[n].1;
                for (slot, gb) in slots.iter().zip(slopes) {
                    slot.add_outer(values, &scaled, gb);
                }
            }
        }
    }
}
