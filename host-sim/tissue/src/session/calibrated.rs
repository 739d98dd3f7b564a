//! The shipped calibrated patches: a scene on their block gets one automatically.

use palpate::Params;

use super::packed;
use crate::fit_record::FitRecord;
use crate::patch::Patch;
use crate::scene::{Method, Scene, Shape};
use crate::tissue::DEFAULT_NODES;

/// Node counts for which one exists.
pub const SIZES: [usize; 3] = [130, 410, 1020];

const PATCHES: [&[u8]; 3] = [
    include_bytes!("../../../patches/block-130.patch"),
    include_bytes!("../../../patches/block-410.patch"),
    include_bytes!("../../../patches/block-1020.patch"),
];

/// Records of these patches, which `palpate calibrate --check` writes.
const RECORDS: [&str; 3] = [
    include_str!("../../../patches/block-130.patch.json"),
    include_str!("../../../patches/block-410.patch.json"),
    include_str!("../../../patches/block-1020.patch.json"),
];

/// Conditions that the patches were fitted under: block [m], Poisson's ratio, probe radius [m], and
/// the largest distance from the block's centre [probe radii].
const BLOCK_M: [f64; 3] = [0.08, 0.08, 0.04];
const POISSON_RATIO: f64 = 0.45;
const RADIUS_M: f64 = 0.008;
const FITTED_RADII: f64 = 1.5;

/// The patch for a scene and the parameters fitted with it, if block, Poisson's ratio, probe and
/// node count are those of a shipped one and the probe presses within the fitted region. Any
/// stiffness; inclusions are scaled in.
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

/// The patch for a scene exactly as it ships: its limits were measured when it was packed. `None`
/// if anything has to be measured.
pub fn as_shipped(scene: &Scene) -> Option<(Patch, Params)> {
    let unchanged = scene.tissue.inclusion.is_empty()
        && scene.solver.patch.is_none()
        && scene.probe.position_m.unwrap_or_default() == [0.0; 2];
    let (patch, packed) = unchanged.then(|| of(scene, DEFAULT_NODES))??;
    Some((patch, Params { substeps: packed.substeps, ..super::fitted(scene, &packed) }))
}

/// The shipped patch of a size.
#[must_use]
pub fn sized(nodes: usize) -> Option<(Patch, Params)> {
    let size = SIZES.iter().position(|n| *n == nodes)?;
    packed::unpack(PATCHES[size]).ok()
}

/// The shipped patch file of a size.
#[must_use]
pub fn bytes(nodes: usize) -> Option<&'static [u8]> {
    SIZES.iter().position(|n| *n == nodes).map(|size| PATCHES[size])
}

/// The record of the shipped patch of a size.
#[must_use]
pub fn record(nodes: usize) -> Option<FitRecord> {
    let size = SIZES.iter().position(|n| *n == nodes)?;
    serde_json::from_str(RECORDS[size]).ok()
}
