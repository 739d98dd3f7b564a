//! Compares the surface of a pressed patch with that of the finite elements.

use serde::{Deserialize, Serialize};

use super::Judging;
use crate::pressed_patch::PressedPatch;
use crate::statics::{Unbalanced, Vector};
use palpate_tissue::answer::SurfaceGrid;

/// Radius around the centre within which nodes of the top are compared [probe radii].
const AROUND: f64 = 2.5;
/// Distance from the plane of the top up to which a node belongs to it [m].
const TOP_M: f64 = 1e-9;
/// Distance from the centre up to which a place counts as the centre [m].
pub(super) const CENTRED_M: f64 = 1e-9;

/// Errors of the surface under a centred press, at the nodes of the top. At a node inside the probe
/// the surface is the outer face of the foundation; elsewhere it is the node itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfaceVerdict {
    /// Depth [mm].
    pub depth_mm: f64,
    /// Whether the surface at this depth was in the fit.
    pub fitted_depth: bool,
    /// Mean distance from the surface of the finite elements [mm].
    pub mean_mm: f64,
    /// Largest distance from the surface of the finite elements [mm].
    pub most_mm: f64,
}

impl Judging<'_> {
    /// Errors at every depth for which the finite elements have a surface, in the order of
    /// increasing depth.
    pub(super) fn surfaces(&self, pressed: &PressedPatch) -> Result<Vec<SurfaceVerdict>, Unbalanced> {
        let centred = self.unseen.holds.iter().filter(|h| h.place_m[0].hypot(h.place_m[1]) < CENTRED_M);
        let unseen = centred.filter_map(|h| Some((h.depth_m, Some(h.surface.as_ref()?))));
        let known = self.fitted_m.iter().filter(|d| self.known.displacement_m(**d, [0.0; 2]).is_some());
        let mut depths: Vec<(f64, Option<&SurfaceGrid>)> = unseen.chain(known.map(|d| (*d, None))).collect();
        depths.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (statics, site_m) = (&pressed.statics, pressed.site_m);
        let reach_m = AROUND * f64::from(statics.probe.radius_m);
        let top: Vec<usize> = (0..statics.rest_m.len())
            .filter(|n| {
                let offset = statics.rest_m[*n] - site_m;
                offset.z.abs() < TOP_M && offset.norm() <= reach_m
            })
            .collect();
        let mut grids = depths.iter();
        let verdicts = pressed.press(Vector::zeros(), depths.iter().map(|d| d.0), |depth_m, here| {
            let grid = grids.next().and_then(|d| d.1);
            let off = |n: &usize| {
                let rest_m = statics.rest_m[*n];
                let at = [rest_m.x - site_m.x, rest_m.y - site_m.y];
                let wanted = grid.map_or_else(|| self.known.displacement_m(depth_m, at), |grid| grid.at_m(at))?;
                Some((here.surface_m(statics, *n) - rest_m - Vector::from(wanted)).norm() * 1e3)
            };
            let off_mm: Vec<f64> = top.iter().filter_map(off).collect();
            (!off_mm.is_empty()).then(|| SurfaceVerdict {
                depth_mm: depth_m * 1e3,
                fitted_depth: grid.is_none(),
                mean_mm: off_mm.iter().sum::<f64>() / off_mm.len() as f64,
                most_mm: off_mm.iter().copied().fold(0.0, f64::max),
            })
        })?;
        Ok(verdicts.into_iter().flatten().collect())
    }
}
