//! Makes the tissue under a finger from a scene of paper 004: mesh, layers, support, and the place
//! that is pressed.

use palpate::{Params, ProbeShape, Vector3};

use super::scene::PressScene;
use crate::error::Error;
use crate::methods::Block;
use palpate_fit::reference::refine::refine;
use palpate_tissue::mesh::TetMesh;
use palpate_tissue::mesh::import::import;
use palpate_tissue::mesh::surface::surface;
use palpate_tissue::mesh::triangle::entry_m;
use palpate_tissue::organ::{Fine, Organ, Spec};
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
    /// Name and Young's modulus [Pa] of each layer.
    pub layers: Vec<(String, f64)>,
    organ: Option<Organ>,
    by_number: Vec<(u32, f64)>,
}

impl Site {
    /// Meshes the organ or reads its mesh file; `coarser` multiplies the spacing of the lattice.
    pub fn of(scene: &PressScene, coarser: f64) -> Result<Self, Error> {
        let organ =
            scene.organ.as_deref().map(Organ::named).transpose().map_err(|cause| scene.bad("organ:", &cause.to_string()))?;
        let by_number = moduli_pa(scene, organ.as_ref())?;
        let direction = Vector3::from(scene.finger.direction).normalize();
        let axis = -direction;
        let (mesh, site_m) = match (&organ, scene.mesh) {
            (Some(organ), Some(mesh)) => {
                if organ.implicit_m(scene.finger.from_m) <= 0.0 {
                    return Err(scene.bad("finger.from_m", "is inside the organ: start the ray outside").into());
                }
                let at_m = organ.surface_point(scene.finger.from_m, scene.finger.direction).ok_or_else(|| miss(scene))?;
                let spec = Fine { at_m, radius_m: mesh.fine_radius_m, spacing_m: mesh.spacing_m * coarser, growth: mesh.growth };
                (organ.mesh(&Spec::Fine(spec)).map_err(|cause| scene.bad("mesh:", &cause.to_string()))?, at_m)
            }
            _ => read(scene)?,
        };
        Self::on_mesh(scene, organ, by_number, mesh, site_m, axis)
    }

    /// Refines the mesh until edges near the site are no longer than `edge_m`, for the reference,
    /// in which the layers should not be blended. The mesh has at most `most_nodes` nodes.
    pub fn refined(&self, scene: &PressScene, edge_m: f64, most_nodes: usize) -> Result<Self, Error> {
        let tissue = &self.block.tissue;
        let (place, reach_m) = (Vector3::from(tissue.site_m), 1.2 * scene.finger.radius_m);
        let longest_m = |x: [f64; 3]| edge_m + EDGE_GROWTH * ((Vector3::from(x) - place).norm() - reach_m).max(0.0);
        let mut mesh = refine(&tissue.mesh, longest_m, most_nodes.max(tissue.mesh.nodes_m.len()));
        if let Some(organ) = &self.organ {
            let centroid =
                |tet: &[u32; 4]| [0, 1, 2].map(|k| tet.iter().map(|n| mesh.nodes_m[*n as usize][k]).sum::<f64>() / 4.0);
            mesh.regions = mesh.tets.iter().map(|tet| organ.region_at(centroid(tet))).collect();
        }
        let axis = self.block.params.probe.axis.cast();
        Self::on_mesh(scene, self.organ, self.by_number.clone(), mesh, tissue.site_m, axis)
    }

    fn on_mesh(
        scene: &PressScene,
        organ: Option<Organ>,
        by_number: Vec<(u32, f64)>,
        mesh: TetMesh,
        site_m: [f64; 3],
        axis: Vector3<f64>,
    ) -> Result<Self, Error> {
        let youngs_pa = |number: u32| by_number.iter().find(|(n, _)| *n == number).map(|(_, e)| *e);
        if let Some(number) = mesh.regions.iter().find(|n| youngs_pa(**n).is_none()) {
            let why = format!("is missing for region {number} of the mesh: add [[region]] with number = {number}");
            return Err(scene.bad("region", &why).into());
        }
        let modulus = |number| youngs_pa(number).unwrap_or(f64::NAN);
        let per_tet_pa: Vec<f64> = match &organ {
            Some(organ) => mesh.tets.iter().map(|tet| blended(&mesh, tet, |x| modulus(organ.region_at(x)))).collect(),
            None => mesh.regions.iter().map(|n| modulus(*n)).collect(),
        };
        let reference_pa = mean_near(&mesh, &per_tet_pa, site_m, scene.finger.radius_m);
        let anchors = held(&mesh, axis.into(), organ.as_ref());
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
        let layers = scene.region.iter().map(|r| {
            let name = r.name.clone().or(r.number.map(|n| format!("region {n}"))).unwrap_or_default();
            (name, r.youngs_modulus_pa)
        });
        Ok(Self { block: Block::of_tissue(tissue, params), layers: layers.collect(), organ, by_number })
    }

    /// Young's modulus at a point of an organ [Pa]; for a mesh file, that of the tet.
    pub fn youngs_modulus_at_pa(&self, tet: usize, at_m: [f64; 3]) -> f64 {
        let e = f64::from(self.block.params.youngs_modulus_pa);
        match &self.organ {
            Some(organ) => self.by_number.iter().find(|(n, _)| *n == organ.region_at(at_m)).map_or(e, |(_, e)| *e),
            None => self.block.tissue.stiffness_ratio.get(tet).map_or(e, |ratio| ratio * e),
        }
    }
}

fn miss(scene: &PressScene) -> SceneFailure {
    scene.bad("finger.from_m", "and finger.direction miss the organ: aim the ray at it")
}

type SceneFailure = palpate_tissue::scene::SceneError;

/// Number and Young's modulus [Pa] of each region.
fn moduli_pa(scene: &PressScene, organ: Option<&Organ>) -> Result<Vec<(u32, f64)>, SceneFailure> {
    let Some(organ) = organ else {
        return Ok(scene.region.iter().filter_map(|r| Some((r.number?, r.youngs_modulus_pa))).collect());
    };
    let known = || organ.regions().iter().map(|r| r.name).collect::<Vec<_>>().join(", ");
    for (n, region) in scene.region.iter().enumerate() {
        let name = region.name.as_deref().unwrap_or_default();
        if !organ.regions().iter().any(|r| r.name == name) {
            let why = format!("= \"{name}\" is no region of the {}: give one of {}", organ.name(), known());
            return Err(scene.bad(&format!("region[{n}].name"), &why));
        }
    }
    let found = organ.regions().iter().map(|region| {
        let given = scene.region.iter().find(|r| r.name.as_deref() == Some(region.name));
        let missing =
            || scene.bad("region", &format!("\"{}\" is missing: give its Young's modulus in a [[region]]", region.name));
        given.map(|r| (region.id, r.youngs_modulus_pa)).ok_or_else(missing)
    });
    found.collect()
}

/// Reads the mesh file and finds the point at which the ray enters its surface.
fn read(scene: &PressScene) -> Result<(TetMesh, [f64; 3]), Error> {
    let (Some(path), Some(unit)) = (&scene.mesh_file, scene.length_unit) else {
        return Err(scene.bad("organ", "or mesh_file: give one of the two").into());
    };
    let mesh = import(path, unit.metres)?.mesh;
    let (from, direction) = (Vector3::from(scene.finger.from_m), Vector3::from(scene.finger.direction).normalize());
    let hits =
        surface(&mesh.tets).into_iter().filter_map(|t| entry_m(t.map(|n| mesh.nodes_m[n as usize].into()), &from, &direction));
    let displacement_m = hits.min_by(f64::total_cmp).ok_or_else(|| miss(scene))?;
    Ok((mesh, (from + direction * displacement_m).into()))
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
