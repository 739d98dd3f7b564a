//! The calibrated patches that are shipped: a scene on their block uses one automatically.

use palpate::Params;

use super::packed;
use crate::fit_record::FitRecord;
use crate::patch::Patch;
use crate::scene::{Method, Scene, Shape};
use crate::tissue::DEFAULT_NODES;

/// Numbers of nodes for which a calibrated patch is shipped.
pub const SIZES: [usize; 3] = [130, 410, 1020];

const PATCHES: [&[u8]; 3] = [
    include_bytes!("../../../patches/block-130.patch"),
    include_bytes!("../../../patches/block-410.patch"),
    include_bytes!("../../../patches/block-1020.patch"),
];

/// Records of the fits of these patches.
const RECORDS: [&str; 3] = [
    include_str!("../../../patches/block-130.patch.json"),
    include_str!("../../../patches/block-410.patch.json"),
    include_str!("../../../patches/block-1020.patch.json"),
];

/// Sides of the block that the patches were fitted to [m].
const BLOCK_M: [f64; 3] = [0.08, 0.08, 0.04];
/// Poisson's ratio that the patches were fitted with (1).
const POISSON_RATIO: f64 = 0.45;
/// Radius of the hemisphere that the patches were fitted with [m].
const RADIUS_M: f64 = 0.008;
/// Largest distance of the fitted and of the judged places from the block's centre, in probe radii
/// (1).
const FITTED_RADII: f64 = 1.65;

/// The shipped patch for a scene and the parameters fitted with it, if the scene has the block,
/// Poisson's ratio, probe and number of nodes of a shipped patch and presses within the fitted
/// region. Young's modulus may have any value; inclusions are scaled in.
pub(super) fn of(scene: &Scene, default_nodes: usize) -> Option<(Patch, Params)> {
    let (tissue, probe) = (&scene.tissue, &scene.probe);
    let [x, y] = probe.position_m.unwrap_or_default();
    let same = scene.solver.method == Method::Palpate
        && tissue.block_m == Some(BLOCK_M)
        && tissue.poisson_ratio == POISSON_RATIO
        && probe.shape == Shape::Hemisphere
        && probe.radius_m == RADIUS_M
        && x.hypot(y) <= FITTED_RADII * RADIUS_M;
    let size = SIZES.iter().position(|n| *n == tissue.nodes.unwrap_or(default_nodes))?;
    let (patch, params) = same.then(|| packed::unpack(PATCHES[size]))?.ok()?;
    Some((patch.with_inclusions(&tissue.inclusion), params))
}

/// The shipped patch for a scene without any change: its limits were measured when it was packed.
/// `None` if the scene changes the patch, so that the limits have to be measured again.
pub fn as_shipped(scene: &Scene) -> Option<(Patch, Params)> {
    let unchanged = scene.tissue.inclusion.is_empty()
        && scene.solver.patch.is_none()
        && scene.probe.position_m.unwrap_or_default() == [0.0; 2];
    let (patch, packed) = unchanged.then(|| of(scene, DEFAULT_NODES))??;
    Some((patch, Params { substeps: packed.substeps, ..super::fitted(scene, &packed) }))
}

/// The shipped patch with this number of nodes, and the parameters that it was packed with.
#[must_use]
pub fn sized(nodes: usize) -> Option<(Patch, Params)> {
    let size = SIZES.iter().position(|n| *n == nodes)?;
    packed::unpack(PATCHES[size]).ok()
}

/// The shipped patch file with this number of nodes.
#[must_use]
pub fn bytes(nodes: usize) -> Option<&'static [u8]> {
    SIZES.iter().position(|n| *n == nodes).map(|size| PATCHES[size])
}

/// Record of the fit of the shipped patch with this number of nodes.
#[must_use]
pub fn record(nodes: usize) -> Option<FitRecord> {
    let size = SIZES.iter().position(|n| *n == nodes)?;
    serde_json::from_str(RECORDS[size]).ok()
}
