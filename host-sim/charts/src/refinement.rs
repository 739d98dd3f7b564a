//! Draws force against depth for meshes of increasing fineness.

use std::path::Path;

use super::ChartError;
use super::axis::Unit;
use super::figure::Figure;
use super::plot::{Dot, Plot, ScaledAxis, Series};

/// Depth [m] and force [N] of every hold on one mesh.
#[derive(Clone, Debug)]
pub struct RefinementLevel {
    /// Number of nodes of the mesh.
    pub nodes: usize,
    /// Pairs (depth \[m\], force \[N\]), in the order of increasing depth.
    pub holds: Vec<(f64, f64)>,
}

/// Results of one press on several meshes.
#[derive(Clone, Copy, Debug)]
pub struct Refinement<'a> {
    /// Name of the scene, with which the title begins.
    pub scene: &'a str,
    /// Line below the title.
    pub caption: &'a str,
    /// Levels from coarse to fine.
    pub levels: &'a [RefinementLevel],
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
///
/// # Errors
/// Fails if there is no hold, if a value cannot be drawn, or if the folder cannot be written.
pub fn refinement(folder: &Path, name: &str, refinement: &Refinement) -> Result<(), ChartError> {
    let all = || refinement.levels.iter().flat_map(|level| level.holds.iter());
    let (length, force) = (Unit::of_length(all().map(|h| h.0)), Unit::of_force(all().map(|h| h.1)));
    let count = refinement.levels.len();
    // the finest mesh is a line; the others are hollow marks of increasing size, so that none hides
    // another
    let series = refinement.levels.iter().enumerate().rev().map(|(n, level)| {
        let coarser = count - 1 - n;
        let at = level.holds.iter().map(|h| (h.0 * length.per_si, h.1 * force.per_si));
        let dot = |at| Dot { radius_px: 3.6 + 2.2 * coarser as f64, hollow: coarser > 0, ..Dot::from(at) };
        Series { joined: coarser == 0, ..Series::dots(format!("{} nodes", level.nodes), at.map(dot).collect()) }
    });
    let [x, y] =
        [("depth", length), ("force", force)].map(|(what, unit)| ScaledAxis::linear(format!("{what} [{}]", unit.symbol)));
    let title = format!("{}: force against depth by finite elements", refinement.scene);
    Figure::plot(name, title, refinement.caption, Plot::new(x, y, series.collect())).draw(folder)
}
