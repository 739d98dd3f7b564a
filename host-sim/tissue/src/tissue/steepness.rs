//! Steepness with which the tissue stiffens at each node of a mesh.
//!
//! The tick applies the law at each node, to the mean energy density w there: the logarithm of a
//! node's stiffness factor is `2 b s w / mu`, with b and mu of the whole patch and s the steepness
//! of the node (`core/src/stages/force/stiffening.rs`). In a region of stiffness ratio r and
//! exponent `b_r`, s is `b_r / (r b)`. At a node between regions, exponents and ratios are averaged
//! over the node's tets. Averages that assume equal strain or equal stress in all these tets agree
//! less well with finite elements (DECISIONS.md).

use super::samples;
use crate::mesh::{TetMesh, six_volume};

/// Steepness of every node of a mesh (1). `tissue_at` gives, at a point [m], the stiffness ratio
/// and the exponent over that of the patch.
#[must_use]
pub fn steepness(mesh: &TetMesh, tissue_at: impl Fn([f64; 3]) -> [f64; 2]) -> Vec<f32> {
    // sums of ratio and exponent, weighted by volume
    let mut sums = vec![[0.0; 2]; mesh.nodes_m.len()];
    for tet in &mesh.tets {
        let (mut of_tet, mut count) = ([0.0; 2], 0.0);
        for at in samples(mesh, tet) {
            of_tet.iter_mut().zip(tissue_at(at)).for_each(|(sum, value)| *sum += value);
            count += 1.0;
        }
        let each = six_volume(mesh, *tet) / count;
        for &n in tet {
            sums[n as usize].iter_mut().zip(of_tet).for_each(|(sum, value)| *sum += each * value);
        }
    }
    sums.iter().map(|[ratio, exponent]| (exponent / ratio) as f32).collect()
}
