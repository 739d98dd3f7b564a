//! Tissue with its supports: a block, cut at its planes of symmetry, or an imported mesh that is
//! supported on its underside.

use nalgebra::Vector3;

use super::body::{Body, Material, Stiffness};
use super::quadratic::QuadraticMesh;
use super::shape::TetRule;
use palpate_tissue::answer::SurfaceGrid;
use palpate_tissue::mesh::{BlockError, BlockSpec, TetMesh, block_of_at_least, surface};
use palpate_tissue::tissue::UNDERSIDE_COSINE;

/// A block that is pressed on its top.
#[derive(Clone, Debug)]
pub struct BlockCase {
    /// Lengths of the sides [m]; the top is centred on the origin, and the bottom is fixed.
    pub size_m: [f64; 3],
    /// Place of the press on the top [m].
    pub place_m: [f64; 2],
    /// Material of the block.
    pub material: Material,
    /// Number of corner nodes of the piece that is meshed: a quarter, a half or the whole.
    pub nodes: usize,
    /// Distance from the place within which elements are smallest [m].
    pub fine_radius_m: f64,
    /// Quadrature rule in the tets.
    pub rule: TetRule,
    /// Whether the block may be cut at the planes x = 0 and y = 0. A symmetric press is computed on
    /// a cut block, unless it is to be compared with one that is not symmetric.
    pub may_cut: [bool; 2],
}

/// The piece of a block that is computed.
pub struct BlockBody {
    /// Mesh of the piece with its supports.
    pub body: Body,
    /// Whether the piece is cut at x = 0 and at y = 0, with mirror images beyond the cut.
    pub mirror: [bool; 2],
    /// Place of the press [m].
    pub place_m: Vector3<f64>,
}

impl BlockCase {
    /// Whether press and tissue are symmetric about the planes x = 0 and y = 0, and the block may
    /// be cut there.
    #[must_use]
    pub fn symmetry(&self) -> [bool; 2] {
        [0, 1].map(|k| {
            self.may_cut[k] && self.place_m[k] == 0.0 && self.material.inclusions.iter().all(|ball| ball.center_m[k] == 0.0)
        })
    }

    /// Meshes the piece and supports it.
    ///
    /// # Errors
    /// See [`BlockError`], the error of the mesh generator.
    pub fn build(&self) -> Result<BlockBody, BlockError> {
        let mirror = self.symmetry();
        let mut size_m = self.size_m;
        let mut shift_m = [0.0; 2];
        for k in 0..2 {
            if mirror[k] {
                size_m[k] *= 0.5;
                shift_m[k] = 0.5 * size_m[k];
            }
        }
        let fine_at_m = [0, 1].map(|k| self.place_m[k] - shift_m[k]);
        let mut mesh = block_of_at_least(&BlockSpec { size_m, nodes: self.nodes, fine_at_m, fine_radius_m: self.fine_radius_m })?;
        for node in &mut mesh.nodes_m {
            for k in 0..2 {
                node[k] += shift_m[k];
            }
        }
        Ok(self.support(&mesh, mirror))
    }

    /// Fixes the bottom of a mesh of the piece and, in the normal direction, the planes of symmetry
    /// at which it was cut.
    #[must_use]
    pub fn support(&self, mesh: &TetMesh, mirror: [bool; 2]) -> BlockBody {
        self.support_with(mesh, mirror, |_, x| self.material.at(x))
    }

    /// Like [`Self::support`], with the stiffness as a function of the tet (by index) and of the
    /// point (rest position [m]).
    #[must_use]
    pub fn support_with(
        &self,
        mesh: &TetMesh,
        mirror: [bool; 2],
        stiffness: impl Fn(usize, &Vector3<f64>) -> Stiffness,
    ) -> BlockBody {
        let mesh = QuadraticMesh::new(mesh);
        let bottom = |x: &Vector3<f64>| x.z <= -self.size_m[2] * (1.0 - 1e-9);
        let fixed = mesh.nodes_m.iter().map(|x| match bottom(x) {
            true => [true; 3],
            false => [mirror[0] && x.x == 0.0, mirror[1] && x.y == 0.0, false],
        });
        let fixed: Vec<[bool; 3]> = fixed.collect();
        let cut = |k: usize, t: &[u32; 6]| mirror[k] && t.iter().all(|n| mesh.nodes_m[*n as usize][k] == 0.0);
        let free = |t: &[u32; 6]| !cut(0, t) && !cut(1, t) && !t.iter().all(|n| bottom(&mesh.nodes_m[*n as usize]));
        let touchable = (0..mesh.triangles.len()).filter(|t| free(&mesh.triangles[*t])).collect();
        let copies = mirror.map(|m| if m { 2.0 } else { 1.0 }).iter().product();
        let body = Body::with_stiffness(mesh, stiffness, fixed, touchable, copies, self.rule);
        BlockBody { body, mirror, place_m: Vector3::new(self.place_m[0], self.place_m[1], 0.0) }
    }
}

/// An imported mesh, supported on its underside. Triangles that face away from the press are fixed,
/// except inside a hollow; all others may touch the probe.
#[must_use]
pub fn mesh_body(mesh: &TetMesh, axis: &Vector3<f64>, material: &Material, rule: TetRule) -> Body {
    // corner nodes keep their numbers in the quadratic mesh
    let hollow = surface::hollow(mesh);
    let mesh = QuadraticMesh::new(mesh);
    let faces_away = |t: &[u32; 6]| {
        if hollow[t[0] as usize] {
            return false;
        }
        let [a, b, c] = [0, 1, 2].map(|k| mesh.nodes_m[t[k] as usize]);
        let normal = (b - a).cross(&(c - a));
        normal.dot(axis) < UNDERSIDE_COSINE * normal.norm()
    };
    let mut fixed = vec![[false; 3]; mesh.nodes_m.len()];
    let mut touchable = Vec::new();
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        if faces_away(triangle) {
            for n in triangle {
                fixed[*n as usize] = [true; 3];
            }
        } else {
            touchable.push(index);
        }
    }
    Body::new(mesh, material, fixed, touchable, 1.0, rule)
}

impl BlockBody {
    /// Displacement of the top at a place [m], which is mirrored into the computed piece if
    /// necessary; zero outside the block.
    #[must_use]
    pub fn top_displacement_m(&self, displacement_m: &[Vector3<f64>], at_m: [f64; 2]) -> Vector3<f64> {
        let sign = [0, 1].map(|k| if self.mirror[k] && at_m[k] < 0.0 { -1.0 } else { 1.0 });
        let at = Vector3::new(at_m[0] * sign[0], at_m[1] * sign[1], 0.0);
        let u = self.body.surface_at(displacement_m, &at).unwrap_or_default();
        Vector3::new(u.x * sign[0], u.y * sign[1], u.z)
    }

    /// Displacement around the place of the press, on a square grid.
    #[must_use]
    pub fn grid(&self, displacement_m: &[Vector3<f64>], spacing_m: f64, half_count: usize) -> SurfaceGrid {
        SurfaceGrid::sample(spacing_m, half_count, |[x, y]| {
            self.top_displacement_m(displacement_m, [self.place_m.x + x, self.place_m.y + y]).into()
        })
    }
}
