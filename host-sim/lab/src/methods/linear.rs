//! Stiffness matrix of linear elasticity with linear tets, divided by E, between the free nodes.

use palpate::Vector3;

use super::{Block, RestTet};

/// Entries of the matrix over E [m], `K_ij = sum_t V (lambda g_i g_j^T + mu g_j g_i^T + mu g_i .
/// g_j 1)`.
#[derive(Clone, Debug)]
pub struct LinearElastic {
    /// First row of each node, `None` where it is fixed, shape \[nodes\].
    pub row: Vec<Option<usize>>,
    /// Number of rows: three per free node.
    pub rows: usize,
    /// (row, column, value) in the lower triangle; the values of duplicates are to be summed.
    pub lower: Vec<(usize, usize, f64)>,
}

impl LinearElastic {
    /// Assembles the stiffness matrix of a block.
    pub fn of(block: &Block) -> Self {
        let mut rows = 0;
        let row: Vec<Option<usize>> = block
            .fixed()
            .into_iter()
            .map(|fixed| {
                rows += usize::from(!fixed) * 3;
                (!fixed).then(|| rows - 3)
            })
            .collect();
        let (lambda, mu) = block.lame_over_modulus();
        let mut lower = Vec::new();
        for tet in RestTet::of(block) {
            let gradient = tet.all_gradients().map(|g| g.cast::<f64>());
            let volume = f64::from(tet.volume_m3) * f64::from(tet.stiffness_ratio);
            for (&n, g) in tet.node.iter().zip(&gradient) {
                for (&m, h) in tet.node.iter().zip(&gradient) {
                    let (Some(r), Some(c)) = (row[n as usize], row[m as usize]) else { continue };
                    for a in 0..3 {
                        for b in (0..3).filter(|b| r + a >= c + b) {
                            let same = if a == b { g.dot(h) } else { 0.0 };
                            lower.push((r + a, c + b, volume * (lambda * g[a] * h[b] + mu * (h[a] * g[b] + same))));
                        }
                    }
                }
            }
        }
        Self { row, rows, lower }
    }

    /// Expands a solution to all nodes; fixed nodes get zero.
    pub(super) fn spread<T: Copy + Into<f64>>(&self, solution: &[T], into: &mut [Vector3<f32>]) {
        for (row, u) in self.row.iter().zip(into) {
            *u = row.map_or(Vector3::zeros(), |r| Vector3::from_fn(|k, _| solution[r + k].into() as f32));
        }
    }
}
