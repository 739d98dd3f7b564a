//! Elastic support of the rim of a patch: a quadratic energy of the displacements of the rim nodes.

use faer::Mat;
use nalgebra::Matrix3;
use palpate::Model;

use super::{Statics, Vector};

/// Stiffness of the outside over E, between rim nodes.
#[derive(Clone, Debug)]
pub struct Rim {
    /// Indices of the rim nodes in the patch.
    pub node: Vec<usize>,
    /// Stiffness over E [m], shape [3 rim nodes][3 rim nodes], symmetric.
    pub stiffness_m: Mat<f64>,
}

impl Rim {
    /// Support by the rim springs of a model; `None` if it has none.
    pub(super) fn of(model: &Model) -> Option<Self> {
        let node: Vec<usize> = model.rim_nodes.iter().map(|r| r.node as usize).collect();
        let place = |n: u16| node.iter().position(|m| *m == usize::from(n));
        let mut full = Mat::zeros(3 * node.len(), 3 * node.len());
        for (k, r) in model.rim_nodes.iter().enumerate() {
            let [xx, yy, zz, xy, xz, yz] = r.block_m.map(f64::from);
            for (a, row) in [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].iter().enumerate() {
                row.iter().enumerate().for_each(|(b, v)| full[(3 * k + a, 3 * k + b)] = *v);
            }
        }
        for e in model.rim_edges {
            let (Some(i), Some(j)) = (place(e.node[0]), place(e.node[1])) else { continue };
            for (n, v) in e.block_m.iter().enumerate() {
                full[(3 * i + n / 3, 3 * j + n % 3)] = f64::from(*v);
                full[(3 * j + n % 3, 3 * i + n / 3)] = f64::from(*v);
            }
        }
        (!node.is_empty()).then_some(Self { node, stiffness_m: full })
    }

    /// Adds the gradient of the energy over E to `slope` [m^2].
    pub(super) fn add_slope(&self, rest_m: &[Vector], x_m: &[Vector], slope: &mut [Vector]) {
        let moved: Vec<Vector> = self.node.iter().map(|n| x_m[*n] - rest_m[*n]).collect();
        for (i, n) in self.node.iter().enumerate() {
            slope[*n] += (0..moved.len()).map(|j| self.block(i, j) * moved[j]).sum::<Vector>();
        }
    }

    /// Block between rim nodes `i` and `j` [m].
    pub(super) fn block(&self, i: usize, j: usize) -> Matrix3<f64> {
        Matrix3::from_fn(|a, b| self.stiffness_m[(3 * i + a, 3 * j + b)])
    }
}

impl Statics {
    /// Returns the patch with another far field: `stiffness_m` is its stiffness over E between the
    /// rim nodes, shape [3 rim nodes][3 rim nodes].
    #[must_use]
    pub fn with_rim(&self, node: &[usize], stiffness_m: &Mat<f64>) -> Self {
        Self { rim: Some(Rim { node: node.to_vec(), stiffness_m: stiffness_m.clone() }), ..self.clone() }
    }

    /// Returns the patch with further nodes fixed.
    #[must_use]
    pub fn with_fixed(&self, node: &[usize]) -> Self {
        let mut fixed = self.clone();
        node.iter().for_each(|n| fixed.free[*n] = None);
        fixed.free.iter_mut().flatten().enumerate().for_each(|(n, slot)| *slot = n);
        fixed
    }
}
