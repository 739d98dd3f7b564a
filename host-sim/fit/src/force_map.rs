//! Interpolates solved forces between their places and depths.

mod block;
mod surface;

pub use block::BlockForces;
pub use surface::SurfaceForces;

use crate::calibrate::targets::Reference;

/// Forces over depth and place.
#[derive(Clone, Debug)]
pub enum ForceMap {
    /// Forces over the flat top of a block.
    Block(BlockForces),
    /// Forces over the surface of a mesh.
    Surface(Box<SurfaceForces>),
}

impl ForceMap {
    /// Root mean square of the relative errors of the map at the solved places (1).
    #[must_use]
    pub fn misfit(&self) -> f64 {
        match self {
            Self::Block(_) => 0.0,
            Self::Surface(map) => map.misfit,
        }
    }

    /// The map as a reference for a fit and for its evaluation.
    #[must_use]
    pub fn reference(&self) -> &dyn Reference {
        match self {
            Self::Block(map) => map,
            Self::Surface(map) => map.as_ref(),
        }
    }
}

/// Interpolates by a cubic in the logarithm of the depth, through the four of at least four
/// ascending depths that are nearest to `depth_m`; `value` returns the value at a solved depth.
fn cubic(depths_m: &[f64], depth_m: f64, value: impl Fn(usize) -> f64) -> f64 {
    let above = depths_m.partition_point(|d| *d < depth_m);
    let first = above.saturating_sub(2).min(depths_m.len() - 4);
    let mut sum = 0.0;
    for n in first..first + 4 {
        let others = (first..first + 4).filter(|m| *m != n);
        let share: f64 = others.map(|m| (depth_m / depths_m[m]).ln() / (depths_m[n] / depths_m[m]).ln()).product();
        sum += share * value(n);
    }
    sum
}
