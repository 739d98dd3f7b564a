//! Mesh of an organ or a closed surface for a scene, graded so that it is finest at the site.

use super::organ_source::{OrganSource, Site};
use crate::mesh::TetMesh;
use crate::organ::{Fine, OrganError, Turned};
use crate::scene::{Scene, SceneError};

/// Number of nodes of an organ if the scene gives none.
pub const DEFAULT_ORGAN_NODES: usize = 600;
/// Distance from the site within which elements are smallest, in probe radii (1).
const FINE_RADII: f64 = 1.25;
const GROWTH: f64 = 1.0;
/// Least number of lattice cubes through the organ under the site (1). Nodes lie half a cube apart,
/// so that each cube gives at least two elements.
pub const THROUGH: f64 = 2.0;
/// Smallest and largest spacing that is tried, in probe radii (1).
const SPACING_RADII: [f64; 2] = [0.12, 3.0];
/// Number of bisections of the spacing.
const HALVINGS: u32 = 12;
/// Largest accepted deviation from the wanted number of nodes (1).
const WORST_SHARE: f64 = 0.15;

/// Meshes a shape with about the number of nodes that the scene asks for.
pub(super) fn graded(scene: &Scene, shape: &OrganSource, site: &Site) -> Result<TetMesh, SceneError> {
    let wanted = scene.tissue.nodes.unwrap_or(DEFAULT_ORGAN_NODES);
    let radius_m = scene.probe.radius_m;
    let coarsest_m = shape.thickness_m(site) / THROUGH;
    let with = |spacing_m: f64| {
        let fine = Fine { at_m: site.at_m, radius_m: FINE_RADII * radius_m, spacing_m, growth: GROWTH };
        shape.mesh(&Turned { fine, axis: site.axis, stroke_m: [0.0; 3], coarsest_m: coarsest_m.max(spacing_m) })
    };
    let [mut low, mut high] = SPACING_RADII.map(|radii| (radii * radius_m).ln());
    let mut best: Option<TetMesh> = None;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        match with(middle.exp()) {
            Ok(mesh) => {
                let nodes = mesh.nodes_m.len();
                if nodes > wanted {
                    low = middle;
                } else {
                    high = middle;
                }
                if best.as_ref().is_none_or(|b| nodes.abs_diff(wanted) < b.nodes_m.len().abs_diff(wanted)) {
                    best = Some(mesh);
                }
            }
            Err(OrganError::Empty { .. } | OrganError::TooCoarse { .. } | OrganError::Inverted { .. }) => high = middle,
            Err(OrganError::TooFine { .. }) => low = middle,
            Err(other) => {
                return scene.bad(
                    if matches!(shape, OrganSource::Organ(_)) { "tissue.organ:" } else { "tissue.mesh:" },
                    &other.to_string(),
                );
            }
        }
    }
    let nearest = best.as_ref().map_or(0, |b| b.nodes_m.len());
    let near_enough = nearest.abs_diff(wanted) as f64 <= WORST_SHARE * wanted as f64;
    best.filter(|_| near_enough).ok_or_else(|| {
        let why =
            format!("= {wanted}: no mesh of the {} at this site has so many, the nearest has {nearest}: give that", shape.name());
        SceneError::value(&scene.file, "tissue.nodes", &why)
    })
}
