//! The finite-element problem of a scene, after a check that it has an answer.

use nalgebra::Vector3;

use palpate_fit::reference::body::Material;
use palpate_fit::reference::refine::refine;
use palpate_tissue::error::Error;
use palpate_tissue::mesh::TetMesh;
use palpate_tissue::scene::Scene;
use palpate_tissue::tissue::Layout;

/// Growth of the longest edge of an imported mesh per distance from the contact (1).
const EDGE_GROWTH: f64 = 0.35;

/// A scene whose tissue can be solved, with the depth for which its meshes are refined.
pub(super) struct Task<'a> {
    pub scene: &'a Scene,
    pub material: Material,
    /// Depth of the deepest press [m].
    pub deepest_m: f64,
}

impl<'a> Task<'a> {
    /// Checks that the tissue has an answer; the depth is zero until it is set.
    pub fn new(scene: &'a Scene) -> Result<Self, Error> {
        let tissue = &scene.tissue;
        if tissue.organ.is_some() && !Layout::of(scene)?.is_uniform() {
            return Ok(scene.bad("tissue.organ", "has regions, which have no answer here: give one of a single stiffness")?);
        }
        if tissue.block_m.is_none() && tissue.mesh.is_none() && tissue.organ.is_none() {
            return Ok(scene.bad("solver.patch", "has no tissue to solve: give tissue.block_m or tissue.mesh")?);
        }
        if tissue.gravity_m_per_s2 != [0.0; 3] {
            return Ok(scene.bad("tissue.gravity_m_per_s2", "has no reference: set it to zero")?);
        }
        if !(0.0..0.4901).contains(&tissue.poisson_ratio) {
            let why = format!("= {} has no reference: stay within 0 .. 0.49", tissue.poisson_ratio);
            return Ok(scene.bad("tissue.poisson_ratio", &why)?);
        }
        let material = Material {
            poisson_ratio: tissue.poisson_ratio,
            stiffening_b: tissue.stiffening_b,
            inclusions: tissue.inclusion.clone(),
        };
        Ok(Self { scene, material, deepest_m: 0.0 })
    }

    /// Distance from the place within which elements are smallest [m].
    pub fn fine_radius_m(&self) -> f64 {
        let deepest_ball = self.material.inclusions.iter().map(|ball| ball.radius_m - ball.center_m[2]).fold(0.0, f64::max);
        (1.1 * self.scene.probe.tip().contact_radius_m(self.deepest_m)).max(deepest_ball.min(1.5 * self.scene.probe.radius_m))
    }

    /// An imported mesh, refined to edges of at most `edge` times the fine radius near the place.
    pub fn refined(&self, mesh: &TetMesh, place: &Vector3<f64>, edge: f64, most_nodes: usize) -> TetMesh {
        let fine_m = self.fine_radius_m();
        let longest_m = |x: [f64; 3]| edge * fine_m + EDGE_GROWTH * ((Vector3::from(x) - place).norm() - fine_m).max(0.0);
        refine(mesh, longest_m, most_nodes.max(mesh.nodes_m.len()))
    }
}
