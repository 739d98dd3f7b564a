//! Makes the tissue under a finger from a scene of paper 004: mesh, layers, support, and the place
//! that is pressed.

use palpate::{Params, ProbeShape, Vector3};

use super::scene::PressScene;
use crate::error::Error;
use crate::methods::Block;
use palpate_fit::reference::refine::refine;
use palpate_tissue::mesh::TetMesh;
use palpate_tissue::organ::{Fine, Organ, Spec};
use palpate_tissue::scene::SceneError;
use palpate_tissue::tissue::Tissue;
use palpate_tissue::tissue::blended;
use palpate_tissue::tissue::organ_source::held;

/// Depth limit [finger radii]: beyond it the shaft of the finger would also touch.
pub const DEEPEST_RADII: f64 = 3.0;
/// Growth of the longest edge per distance from the finger in the mesh of the reference (1).
const EDGE_GROWTH: f64 = 0.35;

/// An organ that is ready to be pressed.
#[derive(Clone, Debug)]
pub struct Site {
    /// Tissue and parameters for the methods. Young's modulus is the mean within a finger's radius
    /// of the site, so that the stiffness of the contact, which follows from it, is that of the
    /// tissue that is touched.
    pub block: Block,
    organ: Organ,
    /// Number and Young's modulus [Pa] of each region.
    by_number: Vec<(u32, f64)>,
}

impl Site {
    /// Meshes the organ; `coarser` multiplies the spacing of the lattice.
    pub fn of(scene: &PressScene, coarser: f64) -> Result<Self, Error> {
        let organ = Organ::named(&scene.organ).map_err(|cause| scene.bad("organ:", &cause.to_string()))?;
        let by_number = moduli_pa(scene, organ)?;
        let axis = -Vector3::from(scene.finger.direction).normalize();
        let at_m = organ
            .surface_point(scene.finger.from_m, scene.finger.direction)
            .ok_or_else(|| scene.bad("finger.from_m", "and finger.direction miss the organ: aim the ray at it"))?;
        let mesh = scene.mesh;
        let spec = Fine { at_m, radius_m: mesh.fine_radius_m, spacing_m: mesh.spacing_m * coarser, growth: mesh.growth };
        let mesh = organ.mesh(&Spec::Fine(spec)).map_err(|cause| scene.bad("mesh:", &cause.to_string()))?;
        Self::on_mesh(scene, organ, by_number, mesh, at_m, axis)
    }

    /// Refines the mesh until edges near the site are no longer than `edge_m`, for the reference,
    /// in which the layers should not be blended. The mesh has at most `most_nodes` nodes.
    pub fn refined(&self, scene: &PressScene, edge_m: f64, most_nodes: usize) -> Result<Self, Error> {
        let tissue = &self.block.tissue;
        let (place, reach_m) = (Vector3::from(tissue.site_m), 1.2 * scene.finger.radius_m);
        let longest_m = |x: [f64; 3]| edge_m + EDGE_GROWTH * ((Vector3::from(x) - place).norm() - reach_m).max(0.0);
        let mut mesh = refine(&tissue.mesh, longest_m, most_nodes.max(tissue.mesh.nodes_m.len()));
        let centroid = |tet: &[u32; 4]| [0, 1, 2].map(|k| tet.iter().map(|n| mesh.nodes_m[*n as usize][k]).sum::<f64>() / 4.0);
        mesh.regions = mesh.tets.iter().map(|tet| self.organ.region_at(centroid(tet))).collect();
        let axis = self.block.params.probe.axis.cast();
        Self::on_mesh(scene, self.organ, self.by_number.clone(), mesh, tissue.site_m, axis)
    }

    fn on_mesh(
        scene: &PressScene,
        organ: Organ,
        by_number: Vec<(u32, f64)>,
        mesh: TetMesh,
        site_m: [f64; 3],
        axis: Vector3<f64>,
    ) -> Result<Self, Error> {
        let youngs_pa = |number: u32| by_number.iter().find(|(n, _)| *n == number).map(|(_, e)| *e);
        let modulus = |number| youngs_pa(number).unwrap_or(f64::NAN);
        let per_tet_pa: Vec<f64> = mesh.tets.iter().map(|tet| blended(&mesh, tet, |x| modulus(organ.region_at(x)))).collect();
        let reference_pa = mean_near(&mesh, &per_tet_pa, site_m, scene.finger.radius_m);
        let anchors = held(&mesh, axis.into(), Some(&organ));
        if anchors.is_empty() {
            return Err(scene
                .bad("finger.direction", "leaves nothing that faces away from the press to rest on: turn it")
                .into());
        }
        let mut params = Params {
            youngs_modulus_pa: reference_pa as f32,
            poisson_ratio: scene.poisson_ratio as f32,
            density_kg_per_m3: scene.density_kg_per_m3 as f32,
            ..Params::default()
        };
        params.probe.shape = ProbeShape::Hemisphere;
        params.probe.radius_m = scene.finger.radius_m as f32;
        params.probe.axis = axis.cast();
        let stiffness_ratio = per_tet_pa.iter().map(|e| e / reference_pa).collect();
        let tissue = Tissue::closed(mesh, stiffness_ratio, anchors, site_m, DEEPEST_RADII * scene.finger.radius_m);
        Ok(Self { block: Block::of_tissue(tissue, params), organ, by_number })
    }

    /// Young's modulus at a point [Pa].
    pub fn youngs_modulus_at_pa(&self, at_m: [f64; 3]) -> f64 {
        let e = f64::from(self.block.params.youngs_modulus_pa);
        self.by_number.iter().find(|(n, _)| *n == self.organ.region_at(at_m)).map_or(e, |(_, e)| *e)
    }
}

/// Number and Young's modulus [Pa] of each region.
fn moduli_pa(scene: &PressScene, organ: Organ) -> Result<Vec<(u32, f64)>, SceneError> {
    let found = organ.regions().iter().map(|region| {
        let given = scene.region.iter().find(|r| r.name == region.name);
        let missing =
            || scene.bad("region", &format!("\"{}\" is missing: give its Young's modulus in a [[region]]", region.name));
        given.map(|r| (region.id, r.youngs_modulus_pa)).ok_or_else(missing)
    });
    found.collect()
}

/// Volume-weighted mean of Young's modulus over the tets that have a corner within `reach_m` of a
/// place [Pa].
fn mean_near(mesh: &TetMesh, per_tet_pa: &[f64], place_m: [f64; 3], reach_m: f64) -> f64 {
    let place = Vector3::from(place_m);
    let (mut sum, mut volume) = (0.0, 0.0);
    for (tet, e) in mesh.tets.iter().zip(per_tet_pa) {
        let [a, b, c, d] = tet.map(|n| Vector3::from(mesh.nodes_m[n as usize]));
        if [a, b, c, d].iter().any(|x| (x - place).norm() <= reach_m) {
            let v = (b - a).cross(&(c - a)).dot(&(d - a));
            sum += e * v;
            volume += v;
        }
    }
    sum / volume
}
