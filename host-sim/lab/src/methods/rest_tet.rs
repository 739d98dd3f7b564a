//! Rest data of a linear tet, which every finite-element method needs.

use palpate::Vector3;

use super::Block;

/// Rows of a 3 x 3 matrix.
pub(super) type Matrix = [Vector3<f32>; 3];

/// Rest data of one tet.
#[derive(Clone, Copy, Debug)]
pub struct RestTet {
    /// Indices of the corners a, b, c, d.
    pub node: [u32; 4],
    /// Rest volume [m^3].
    pub volume_m3: f32,
    /// Stiffness as a multiple of the tissue's (1).
    pub stiffness_ratio: f32,
    /// Gradients of the shape functions of b, c, d [1/m]: the rows of the inverse of (b-a, c-a,
    /// d-a). The gradient of a is minus their sum.
    pub gradient: [Vector3<f32>; 3],
}

impl RestTet {
    /// Rest data of all tets of a block.
    pub fn of(block: &Block) -> Vec<Self> {
        let mesh = &block.tissue.mesh;
        mesh.tets
            .iter()
            .zip(&block.tissue.stiffness_ratio)
            .map(|(tet, &ratio)| {
                let [a, b, c, d] = tet.map(|n| Vector3::from(mesh.nodes_m[n as usize]));
                let (u, v, w) = (b - a, c - a, d - a);
                let six_volume = u.dot(&v.cross(&w));
                let gradient = [v.cross(&w), w.cross(&u), u.cross(&v)].map(|g| (g / six_volume).cast::<f32>());
                Self { node: *tet, volume_m3: (six_volume / 6.0) as f32, stiffness_ratio: ratio as f32, gradient }
            })
            .collect()
    }

    /// Rows of the deformation gradient `F = sum_n x_n g_n^T`.
    #[inline(always)]
    pub(super) fn deformation(&self, position_m: &[Vector3<f32>]) -> Matrix {
        let [a, b, c, d] = self.node.map(|n| position_m[n as usize]);
        let edges = [b - a, c - a, d - a];
        [0, 1, 2].map(|k| self.gradient[0] * edges[0][k] + self.gradient[1] * edges[1][k] + self.gradient[2] * edges[2][k])
    }

    /// Adds the nodal forces `f_n -= V P g_n` of a first Piola-Kirchhoff stress P, given by its
    /// rows.
    #[inline(always)]
    pub(super) fn scatter(&self, stress: &Matrix, force: &mut [Vector3<f32>]) {
        let on = self.gradient.map(|g| Vector3::new(stress[0].dot(&g), stress[1].dot(&g), stress[2].dot(&g)) * -self.volume_m3);
        let [a, b, c, d] = self.node.map(|n| n as usize);
        force[a] -= on[0] + on[1] + on[2];
        force[b] += on[0];
        force[c] += on[1];
        force[d] += on[2];
    }
}

/// Rows of the cofactor matrix, and the determinant.
#[inline(always)]
pub(super) fn cofactors(f: &Matrix) -> (Matrix, f32) {
    let cofactors = [f[1].cross(&f[2]), f[2].cross(&f[0]), f[0].cross(&f[1])];
    (cofactors, f[0].dot(&cofactors[0]))
}

/// Mean diagonal stiffness over E of each node of linear tets [m], the sum of `V (lambda + 4 mu)
/// |g|^2 / 3` over its tets; the mass floor is proportional to it.
pub(super) fn diagonal_m(block: &Block, tets: &[RestTet], lambda: f64, mu: f64) -> Vec<f32> {
    let mut diagonal = vec![0.0_f32; block.tissue.mesh.nodes_m.len()];
    for tet in tets {
        let per_square = tet.volume_m3 * tet.stiffness_ratio * (lambda + 4.0 * mu) as f32 / 3.0;
        for (n, g) in tet.node.iter().zip(tet.all_gradients()) {
            diagonal[*n as usize] += per_square * g.norm_squared();
        }
    }
    diagonal
}

impl RestTet {
    /// Gradients of all four shape functions [1/m].
    pub fn all_gradients(&self) -> [Vector3<f32>; 4] {
        let [b, c, d] = self.gradient;
        [-(b + c + d), b, c, d]
    }
}
