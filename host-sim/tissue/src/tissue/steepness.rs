//! How steeply the tissue at each node of a mesh stiffens.
//!
//! The tick applies the law node by node, to the mean energy density w there: the logarithm of a
//! node's factor is `2 b s w / mu`, with b and mu of the whole patch and s the node's steepness
//! (`core/src/stages/force/stiffening.rs`). In a region of stiffness ratio r and exponent `b_r` it
//! is `b_r / (r b)`; a node between regions has the means over its tets, of exponents and of
//! ratios. Means that assume equal strain or equal stress in all its tets are further off finite
//! elements (DECISIONS.md).

use super::samples;
use crate::mesh::TetMesh;
use crate::patch::six_volume;

/// Steepness of every node of a mesh (1), from the stiffness ratio at every point [m] and the
/// exponent there over the patch's.
#[must_use]
pub fn steepness(mesh: &TetMesh, tissue_at: impl Fn([f64; 3]) -> [f64; 2]) -> Vec<f32> {
    // ratios and exponents times volumes
    let mut sums = vec![[0.0; 2]; mesh.nodes_m.len()];
    for tet in &mesh.tets {
        let (mut of_tet, mut count) = ([0.0; 2], 0.0);
        for at in samples(mesh, tet) {
            of_tet.iter_mut().zip(tissue_at(at)).for_each(|(sum, value)| *sum += value);
            count += 1.0;
        }
        let each = six_volume(mesh, tet) / count;
        for &n in tet {
            sums[n as usize].iter_mut().zip(of_tet).for_each(|(sum, value)| *sum += each * value);
        }
    }
    sums.iter().map(|[ratio, exponent]| (exponent / ratio) as f32).collect()
}
