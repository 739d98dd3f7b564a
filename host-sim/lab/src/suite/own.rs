//! A scene whose tissue is not the preset block: its files, and its tissue for every method.

use std::path::{Path, PathBuf};

use palpate::{Params, Vector3};
use palpate_fit::far_field::prepared::Recipe;
use palpate_fit::far_field::whole::whole;
use palpate_fit::scene_fit::PIECE_RADII;
use palpate_tissue::answer::Answer;
use palpate_tissue::error::Error as TissueError;
use palpate_tissue::mesh::surface::surface;
use palpate_tissue::mesh::triangle::entry_m;
use palpate_tissue::mesh::{BlockSpec, block};
use palpate_tissue::moving::Table;
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::packed::unpack;
use palpate_tissue::tissue::{DEPTH_MARGIN, Tissue, place};

use super::scenes::Cuboid;
use crate::error::Error;
use crate::methods::{Block, Fitted, Method};

/// Speeds of the ramps to 4 mm [mm/s].
pub const SPEEDS_MM_PER_S: [u32; 2] = [40, 200];
/// Depth of the ramps [m].
pub const DEPTH_M: f64 = 0.004;

/// Elements under the probe of a shape that is no block [probe radii], beside the numbers of nodes
/// with which a block has elements of that size.
const ELEMENTS_RADII: [(usize, f64); 3] = [(57, 1.0), (130, 0.75), (410, 0.5)];

/// Distance from the site, over the radius of a piece, beyond which its nodes are fixed for the
/// plain springs beside which its tick is timed (1); its own are held by rim springs.
const RIM: f64 = 0.85;

/// The folder of the scenes.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("suite")
}

/// A table of forces over time in the folder.
pub(super) fn table(name: &str) -> Result<Table, Error> {
    let path = folder().join(format!("{name}.csv"));
    let text = std::fs::read_to_string(&path).map_err(|source| TissueError::Read { path, source })?;
    Ok(Table::parse(name, &text).map_err(TissueError::from)?)
}

/// The patch of a file, and the parameters fitted with it.
pub(super) fn patch(path: &Path) -> Result<(Patch, Params), Error> {
    let bytes = std::fs::read(path).map_err(|source| TissueError::Read { path: path.into(), source })?;
    Ok(unpack(&bytes).map_err(|cause| TissueError::Patch { path: path.into(), cause })?)
}

/// Presses that no fit saw, and ramps of a scene, with what was fitted to it.
pub(super) struct Own {
    pub scene: Scene,
    pub held: Answer,
    pub ramps: Vec<Table>,
    pub fitted: Fitted,
}

impl Own {
    pub fn load(name: &str) -> Result<Self, Error> {
        let file = |end: &str| folder().join(format!("{name}{end}"));
        let scene = Scene::load(&file(".toml").display().to_string()).map_err(TissueError::from)?;
        let held = Answer::load(&file(".json"))?;
        let ramp = |speed: u32| table(&format!("{name}-{speed}"));
        let ramps = SPEEDS_MM_PER_S.into_iter().map(ramp).collect::<Result<_, Error>>()?;
        // a block has the shipped patches, with what is stiffer in it scaled in
        let own_patch = if file(".patch").is_file() { Some(patch(&file(".patch"))?) } else { None };
        let fitted = Fitted { law: Some(patch(&file("-law.patch"))?.0), patch: own_patch };
        Ok(Self { scene, held, ramps, fitted })
    }

    /// The tissue for a method, on a mesh of about this many nodes if it is a block, else with
    /// elements as large as those of a block; `None` if no such mesh holds its shape, or no patch
    /// of this size is shipped.
    pub fn block(&self, cuboid: Option<Cuboid>, method: Method, nodes: usize) -> Option<Block> {
        let mut scene = self.scene.clone();
        let radius_m = scene.probe.radius_m;
        if method == Method::Calibrated {
            let Some((patch, params)) = &self.fitted.patch else {
                scene.tissue.block_m?;
                let plain = Block::calibrated(nodes, scene.tissue.youngs_modulus_pa)?;
                return Some(scene.tissue.inclusion.iter().fold(plain, |block, ball| block.with_inclusion(*ball)));
            };
            let (mesh, site) = (patch.mesh(), patch.site_m().cast::<f64>());
            let away_m = |x: &[f64; 3]| (Vector3::from(*x) - site).norm();
            let rim = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| away_m(x) > RIM * PIECE_RADII * radius_m);
            let anchors = rim.map(|(n, _)| n).collect();
            let stiffness_ratio = vec![1.0; mesh.tets.len()];
            let tissue = Tissue::closed(mesh, stiffness_ratio, anchors, site.into(), DEPTH_MARGIN * DEPTH_M);
            let mut block = Block::of_tissue(tissue, scene.params(params.probe.axis.cast::<f64>().into()));
            block.fitted = self.fitted.clone();
            return Some(block);
        }
        let (tissue, axis) = if let Some(cuboid) = cuboid {
            cuboid.tissue(scene.probe.site.unwrap_or_default(), nodes, radius_m)?
        } else if scene.tissue.block_m.is_some() {
            scene.tissue.nodes = Some(nodes);
            let placed = place(&scene, &[]).ok()?;
            (placed.tissue, placed.axis)
        } else {
            let (_, radii) = ELEMENTS_RADII.into_iter().find(|(of, _)| *of == nodes)?;
            let sizes = Recipe::new(PIECE_RADII * radius_m, radii * radius_m, radius_m).sizes;
            let placed = whole(&scene, &[], &sizes).ok()?;
            (placed.tissue, placed.axis)
        };
        let mut block = Block::of_tissue(tissue, scene.params(axis));
        block.fitted = self.fitted.clone();
        Some(block)
    }
}

impl Cuboid {
    /// Tissue and direction of the press for a site on the top.
    fn tissue(self, site_m: [f64; 3], nodes: usize, radius_m: f64) -> Option<(Tissue, [f64; 3])> {
        let Self { size_m, rise } = self;
        let spec = BlockSpec { size_m, nodes, fine_at_m: [site_m[0], site_m[1]], fine_radius_m: radius_m };
        let mut mesh = block(&spec).ok()?;
        let anchors = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| x[2] <= -size_m[2] * (1.0 - 1e-9)).map(|(n, _)| n);
        let anchors = anchors.collect();
        for [x, _, z] in &mut mesh.nodes_m {
            *z += rise * *x * (1.0 + *z / size_m[2]);
        }
        let stiffness_ratio = vec![1.0; mesh.tets.len()];
        let tissue = Tissue::closed(mesh, stiffness_ratio, anchors, site_m, DEPTH_MARGIN * DEPTH_M);
        let length = rise.hypot(1.0);
        Some((tissue, [-rise / length, 0.0, 1.0 / length]))
    }
}

/// Vector from the site to the place on the surface where a press begins [m], for a place of the
/// finite elements' mesh: what was fitted has that surface, any other method that of its mesh.
pub(super) fn place_m(block: &Block, method: Method, place_m: [f64; 3]) -> Vector3<f64> {
    let place = Vector3::from(place_m);
    let axis: Vector3<f64> = block.params.probe.axis.cast();
    let across = place - axis * place.dot(&axis);
    let fitted = match method {
        Method::Law => block.fitted.law.is_some(),
        Method::Calibrated => block.fitted.patch.is_some(),
        _ => false,
    };
    if fitted || across.norm() == 0.0 {
        return place;
    }
    let (mesh, from_m) = (&block.tissue.mesh, 0.05);
    let from = Vector3::from(block.tissue.site_m) + place + axis * from_m;
    let corners = |t: [u32; 3]| t.map(|n| Vector3::from(mesh.nodes_m[n as usize]));
    let ways = surface(&mesh.tets).into_iter().filter_map(|t| entry_m(corners(t), &from, &-axis));
    let nearest = ways.min_by(|a, b| (a - from_m).abs().total_cmp(&(b - from_m).abs()));
    nearest.map_or(place, |way_m| place + axis * (from_m - way_m))
}
