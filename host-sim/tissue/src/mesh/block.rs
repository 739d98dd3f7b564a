//! The built-in block: a graded, unstructured tet mesh with an exact number of nodes, fine where a
//! probe presses.
//!
//! Nodes are seeded at the wanted density, relaxed like a truss and joined by Delaunay tets; then
//! slivers are removed.

mod delaunay;
mod flip;
mod grading;
mod radius_ratio;
mod relax;
mod rim;
mod seed;
mod shell;
mod sliver;
mod vector;

use self::grading::Grading;
pub use self::radius_ratio::radius_ratio;
use self::relax::relax;
pub use self::rim::{Sizes, block_with_rim};
use self::seed::{Cloud, seed};
use self::sliver::remove_slivers;
use super::TetMesh;
use thiserror::Error;

/// Largest ratio of the longest to the shortest side of a block (1).
const MAX_ASPECT: f64 = 20.0;
const NODES: std::ops::RangeInclusive<usize> = 30..=5000;
/// Smallest radius ratio of a tet in a finished mesh (1).
const MIN_QUALITY: f64 = 0.1;

/// Largest number of nodes of a block around a patch, given by the indices of a patch file.
const MAX_NODES: usize = u16::MAX as usize;
/// Largest growth of the element size per distance around a patch (1): neighbours then differ by at
/// most a factor of 2.
const MAX_GROWTH: f64 = 1.0;

/// Inverse of the step to which coordinates are rounded, in units of the longest side: 2^40.
const ROUNDING: f64 = 1_099_511_627_776.0;

/// A block of tissue centred on x = y = 0, its top face at z = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockSpec {
    /// Sides along x, y, z [m].
    pub size_m: [f64; 3],
    /// Exact number of nodes of the mesh, corners included.
    pub nodes: usize,
    /// Place on the top face at which the elements are smallest [m].
    pub fine_at_m: [f64; 2],
    /// Radius around that place within which elements keep their smallest size [m]; outside they
    /// grow with the distance.
    pub fine_radius_m: f64,
}

/// Why a block cannot be meshed.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "each message says what its fields are")]
pub enum BlockError {
    #[error("block size_m[{axis}] = {value} m: must be finite and above 0")]
    Size { axis: usize, value: f64 },
    #[error("block aspect ratio {ratio:.1}: must be at most {MAX_ASPECT}; make the thin side thicker")]
    Aspect { ratio: f64 },
    #[error("block nodes = {nodes}: must be from {} to {}", NODES.start(), NODES.end())]
    Nodes { nodes: usize },
    #[error("block nodes = {nodes}: too few for these proportions; use at least {least}")]
    TooFew { nodes: usize, least: usize },
    #[error("block fine_at_m[{axis}] = {value} m: outside the top face; must be within {half} m of its centre")]
    Spot { axis: usize, value: f64, half: f64 },
    #[error("block fine_radius_m = {value} m: must be finite and above 0")]
    Radius { value: f64 },
    #[error("block nodes = {nodes}: no sound mesh found; use a few nodes more or fewer")]
    Unsound { nodes: usize },
    #[error("block growth = {value}: must be from 0 to {MAX_GROWTH}")]
    Growth { value: f64 },
    #[error("block radius_m = {value} m: the patch reaches a side or the bottom; use at most {most} m")]
    Swallows { value: f64, most: f64 },
    #[error("block {key} = {value} m: must be finite and above 0")]
    Length { key: &'static str, value: f64 },
    #[error(
        "block fine_m = {value} m: must fit once into the patch radius and twice between site and wall; use at most {most} m"
    )]
    Fine { value: f64, most: f64 },
    #[error("block site: a wall is {wall} m from it, must be at least {least} m, two elements; move it inward")]
    AtWall { wall: f64, least: f64 },
    #[error("block fine_m = {value} m: asks for {nodes} nodes, more than {MAX_NODES}; use at least {least} m")]
    TooMany { value: f64, nodes: usize, least: f64 },
    #[error("block growth = {value}: asks for {nodes} nodes, more than {MAX_NODES} at any fine_m; use at least {least}")]
    TooEven { value: f64, nodes: usize, least: f64 },
    #[error("block fine_m = {value} m: no sound patch found; change it by a few per cent")]
    UnsoundPatch { value: f64 },
}

/// Meshes a block. The same spec gives the same bits on every machine.
///
/// # Errors
/// Fails if the spec is out of bounds, or has too few nodes for its proportions.
pub fn block(spec: &BlockSpec) -> Result<TetMesh, BlockError> {
    let nodes = spec.nodes;
    let mut grading = unit_grading(spec)?;
    let budget = grading.fit(nodes).map_err(|least| BlockError::TooFew { nodes, least })?;
    let mut cloud = seed(&grading, &budget, 0);
    let tets = relax(&mut cloud, &grading).ok_or(BlockError::Unsound { nodes })?;
    let tets = remove_slivers(&mut cloud, &grading, tets);
    let mesh = to_metres(spec.size_m, &cloud, tets);
    let sound = |t: &[u32; 4]| radius_ratio(t.map(|n| mesh.nodes_m[n as usize])) >= MIN_QUALITY;
    if mesh.tets.iter().all(sound) { Ok(mesh) } else { Err(BlockError::Unsound { nodes }) }
}

/// Meshes a block with the nodes of its spec, or with the fewest that its proportions need.
///
/// # Errors
/// The spec is out of bounds for another reason.
pub fn block_of_at_least(spec: &BlockSpec) -> Result<TetMesh, BlockError> {
    match block(spec) {
        Err(BlockError::TooFew { least, .. }) => block(&BlockSpec { nodes: least, ..*spec }),
        meshed => meshed,
    }
}

/// The block of a spec in units of its longest side.
fn unit_grading(spec: &BlockSpec) -> Result<Grading, BlockError> {
    check_size(spec.size_m)?;
    if !NODES.contains(&spec.nodes) {
        return Err(BlockError::Nodes { nodes: spec.nodes });
    }
    check_spot(spec.size_m, spec.fine_at_m)?;
    if !(spec.fine_radius_m.is_finite() && spec.fine_radius_m > 0.0) {
        return Err(BlockError::Radius { value: spec.fine_radius_m });
    }
    Ok(unit_box(spec.size_m, spec.fine_at_m, spec.fine_radius_m))
}

fn check_size(size_m: [f64; 3]) -> Result<(), BlockError> {
    for (axis, value) in size_m.into_iter().enumerate() {
        if !(value.is_finite() && value > 0.0) {
            return Err(BlockError::Size { axis, value });
        }
    }
    let longest = size_m.into_iter().fold(0.0, f64::max);
    let ratio = longest / size_m.into_iter().fold(longest, f64::min);
    if ratio > MAX_ASPECT { Err(BlockError::Aspect { ratio }) } else { Ok(()) }
}

fn check_spot(size_m: [f64; 3], at_m: [f64; 2]) -> Result<(), BlockError> {
    for (axis, value) in at_m.into_iter().enumerate() {
        let half = 0.5 * size_m[axis];
        if value.is_nan() || value.abs() > half {
            return Err(BlockError::Spot { axis, value, half });
        }
    }
    Ok(())
}

/// A length in units of the block's longest side, rounded so that blocks of one shape give the same
/// bits at every size.
fn to_unit(size_m: [f64; 3], length_m: f64) -> f64 {
    let longest = size_m.into_iter().fold(0.0, f64::max);
    (length_m / longest * ROUNDING).round() / ROUNDING
}

fn unit_box(size_m: [f64; 3], at_m: [f64; 2], fine_radius_m: f64) -> Grading {
    let unit = |x: f64| to_unit(size_m, x);
    let half = [0.5 * unit(size_m[0]), 0.5 * unit(size_m[1])];
    let [x, y] = at_m.map(unit);
    Grading {
        low: [-half[0], -half[1], -unit(size_m[2])],
        high: [half[0], half[1], 0.0],
        spot: [x.clamp(-half[0], half[0]), y.clamp(-half[1], half[1]), 0.0],
        shell: None,
        fine_radius: unit(fine_radius_m),
        fine_size: 0.0,
        growth: 0.0,
    }
}

fn to_metres(size_m: [f64; 3], cloud: &Cloud, tets: Vec<[u32; 4]>) -> TetMesh {
    let longest = size_m.into_iter().fold(0.0, f64::max);
    let high = [0.5 * size_m[0], 0.5 * size_m[1], 0.0];
    let low = [-high[0], -high[1], -size_m[2]];
    // Face nodes get the face's exact coordinate, which conversion to the unit and back would
    // round.
    let coordinate = |i: usize, k: usize| match (cloud.pinned[i][k], cloud.at[i][k] == cloud.at[0][k]) {
        (true, true) => low[k],
        (true, false) => high[k],
        (false, _) => cloud.at[i][k] * longest,
    };
    TetMesh {
        nodes_m: (0..cloud.at.len()).map(|i| std::array::from_fn(|k| coordinate(i, k))).collect(),
        regions: vec![0; tets.len()],
        tets,
    }
}
