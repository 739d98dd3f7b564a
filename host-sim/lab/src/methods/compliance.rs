//! Linear precomputed compliance (Cotin et al. 1999; James and Pai 1999): the response of all nodes
//! to a unit force on each surface node is solved beforehand, and a tick solves only the contact.
//!
//! The stiffness matrix is that of linear tets at rest, factored in `f64`; the tick works in single
//! precision. There is no inertia: every tick gives the static solution. The tick computes only the
//! nodes that the probe can touch; the positions of the others are computed when they are read.

use palpate::{Fault, Vector3};

use super::node_contact::NodeContact;
use super::{Block, Factor, LinearElastic, RunningMethod};
use palpate_tissue::error::Error;

/// Precomputed response of all nodes, and the contact that is solved with it.
pub struct Compliance {
    contact: NodeContact,
    rest_m: Vec<Vector3<f32>>,
    /// Displacement of all nodes per force over E on each coordinate of each touchable node [1/m].
    columns: Vec<Vec<Vector3<f32>>>,
    youngs_modulus_pa: f32,
}

impl Compliance {
    /// Computes the displacements for a unit force on each touchable node.
    pub fn new(block: &Block) -> Result<Self, Error> {
        let linear = LinearElastic::of(block);
        let mut factor = Factor::<f64>::new(linear.rows, &linear.lower)?;
        let nodes = NodeContact::nodes_of(block);
        let columns = columns(&linear, &nodes, |unit| factor.solve(unit));
        let mut contact = NodeContact::new(block, nodes, &columns);
        let rest_m: Vec<Vector3<f32>> = block.tissue.mesh.nodes_m.iter().map(|x| Vector3::from(x.map(|c| c as f32))).collect();
        for (free, &n) in contact.free_m.iter_mut().zip(&contact.nodes) {
            *free = rest_m[n as usize];
        }
        Ok(Self { contact, rest_m, columns, youngs_modulus_pa: block.params.youngs_modulus_pa })
    }
}

/// Displacements of all nodes for a unit force on each coordinate of each of `nodes`; `solve`
/// replaces a right-hand side by its solution.
pub(super) fn columns<T: Copy + From<f32> + Into<f64>>(
    linear: &LinearElastic,
    nodes: &[u32],
    mut solve: impl FnMut(&mut [T]),
) -> Vec<Vec<Vector3<f32>>> {
    let mut columns = Vec::with_capacity(3 * nodes.len());
    for &n in nodes {
        for k in 0..3 {
            let mut unit = vec![T::from(0.0); linear.rows];
            let mut column = vec![Vector3::zeros(); linear.row.len()];
            // a fixed node does not move: its column is zero
            if let Some(row) = linear.row[n as usize] {
                unit[row + k] = T::from(1.0);
                solve(&mut unit);
                linear.spread(&unit, &mut column);
            }
            columns.push(column);
        }
    }
    columns
}

impl RunningMethod for Compliance {
    fn tick(&mut self, tip_m: Vector3<f32>) -> Result<Vector3<f32>, Fault> {
        let force = self.contact.solve(tip_m) * -self.youngs_modulus_pa;
        if force.iter().all(|f| f.is_finite()) { Ok(force) } else { Err(Fault::ForceNotFinite) }
    }

    fn position_m(&self, node: usize) -> Vector3<f32> {
        let mut x = self.rest_m[node];
        for (force, columns) in self.contact.force.iter().zip(self.columns.chunks_exact(3)) {
            x += columns[0][node] * force.x + columns[1][node] * force.y + columns[2][node] * force.z;
        }
        x
    }

    fn solver_flops(&self) -> f64 {
        self.contact.flops
    }
}
