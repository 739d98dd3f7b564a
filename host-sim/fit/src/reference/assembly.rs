//! Pattern of the sparse matrix, and its assembly from elements.

use nalgebra::{Matrix3, Vector3};

use super::cholesky::Cholesky;
use super::elimination::eliminate;
use super::quadratic::QuadraticMesh;

/// Positions of the 3 x 3 blocks of node pairs in the lower triangle of the matrix.
pub struct Pattern {
    nodes: usize,
    /// The blocks of block column `j` are `block_start[j]..block_start[j + 1]`; the first is on the
    /// diagonal.
    block_start: Vec<usize>,
    /// Block row of every block, ascending within a column.
    block_row: Vec<u32>,
}

impl Pattern {
    /// The blocks of a mesh, and the blocks between all nodes of each group.
    pub fn new(mesh: &QuadraticMesh, groups: &[[u32; 12]]) -> Self {
        let count = mesh.nodes_m.len();
        let mut neighbours = vec![Vec::new(); count];
        for together in mesh.tets.iter().map(|t| t.as_slice()).chain(groups.iter().map(|g| g.as_slice())) {
            for i in together {
                neighbours[*i as usize].extend(together.iter().filter(|j| *j != i));
            }
        }
        for list in &mut neighbours {
            list.sort_unstable();
            list.dedup();
        }
        let mut block_start = vec![0];
        let mut block_row = Vec::new();
        for (n, around) in (0_u32..).zip(&neighbours) {
            block_row.push(n);
            block_row.extend(around.iter().copied().filter(|m: &u32| *m > n));
            block_start.push(block_row.len());
        }
        Self { nodes: count, block_start, block_row }
    }

    /// Number of entries of the lower triangle, including all nine of each diagonal block.
    pub fn entries(&self) -> usize {
        9 * self.block_row.len()
    }

    /// Analyses the factorisation, with the nodes `last` eliminated at the end in their given
    /// order; `None` if there is not enough memory for the factor.
    pub(crate) fn analyse(&self, last: &[u32]) -> Option<Cholesky> {
        let below = |n: usize| &self.block_row[self.block_start[n] + 1..self.block_start[n + 1]];
        let order = eliminate(self.nodes, below, last)?;
        let order = order.into_iter().flat_map(|n| (0..3).map(move |k| 3 * n as usize + k)).collect();
        let mut column_start = vec![0];
        let mut row = Vec::with_capacity(self.entries());
        for column in self.block_start.windows(2) {
            let blocks = &self.block_row[column[0]..column[1]];
            for _ in 0..3 {
                row.extend(blocks.iter().flat_map(|b| (0..3).map(|k| 3 * *b as usize + k)));
                column_start.push(row.len());
            }
        }
        Cholesky::analyse(column_start, row, order)
    }

    /// Adds the block (row node i, column node j) to the lower triangle, transposed if its position
    /// is above the diagonal. Does nothing if `values` is empty.
    pub fn add(&self, values: &mut [f64], i: u32, j: u32, block: &Matrix3<f64>) {
        if values.is_empty() {
            return;
        }
        let (row, column, turned) = if i >= j { (i, j as usize, false) } else { (j, i as usize, true) };
        let (start, end) = (self.block_start[column], self.block_start[column + 1]);
        let Ok(at) = self.block_row[start..end].binary_search(&row) else { return };
        let stride = 3 * (end - start);
        for c in 0..3 {
            let first = 9 * start + c * stride + 3 * at;
            for r in 0..3 {
                values[first + r] += if turned { block[(c, r)] } else { block[(r, c)] };
            }
        }
    }

    /// Adds a multiple of the identity to the block of nodes `i` and `j`.
    pub fn add_scalar(&self, values: &mut [f64], i: u32, j: u32, value: f64) {
        self.add(values, i, j, &Matrix3::from_diagonal_element(value));
    }

    /// Index of diagonal entry `c` of node `n`.
    fn diagonal(&self, n: usize, c: usize) -> usize {
        let (start, end) = (self.block_start[n], self.block_start[n + 1]);
        9 * start + c * 3 * (end - start) + c
    }

    /// Multiplies every diagonal entry by `1 + share`.
    pub fn strengthen(&self, values: &mut [f64], share: f64) {
        for n in 0..self.nodes {
            for c in 0..3 {
                values[self.diagonal(n, c)] *= 1.0 + share;
            }
        }
    }

    /// Product of the symmetric matrix and a vector over nodes.
    pub fn multiply(&self, values: &[f64], vector: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut product = vec![Vector3::zeros(); vector.len()];
        for (column, ends) in self.block_start.windows(2).enumerate() {
            let stride = 3 * (ends[1] - ends[0]);
            for (at, row) in self.block_row[ends[0]..ends[1]].iter().enumerate() {
                let row = *row as usize;
                let block = Matrix3::from_fn(|r, c| values[9 * ends[0] + c * stride + 3 * at + r]);
                product[row] += block * vector[column];
                if row != column {
                    product[column] += block.transpose() * vector[row];
                }
            }
        }
        product
    }

    /// Replaces the rows and columns of fixed components by those of the identity.
    pub fn fix(&self, values: &mut [f64], fixed: &[[bool; 3]]) {
        for (column, ends) in self.block_start.windows(2).enumerate() {
            let stride = 3 * (ends[1] - ends[0]);
            for (at, row) in self.block_row[ends[0]..ends[1]].iter().enumerate() {
                for c in 0..3 {
                    for r in 0..3 {
                        if fixed[column][c] || fixed[*row as usize][r] {
                            let one = *row as usize == column && r == c;
                            values[9 * ends[0] + c * stride + 3 * at + r] = if one { 1.0 } else { 0.0 };
                        }
                    }
                }
            }
        }
    }
}
