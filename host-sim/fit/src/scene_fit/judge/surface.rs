//! Compares the surface of a pressed patch with that of the finite elements.

use serde::{Deserialize, Serialize};

use super::Judging;
use crate::settled::SettledPatch;
use crate::statics::Vector;
use palpate_tissue::answer::SurfaceGrid;
use palpate_tissue::error::Error;
use palpate_tissue::probe_surface::outer_face_m;
use palpate_tissue::session::Session;

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
    pub(super) fn surfaces(&self, settled: &SettledPatch, session: &Session) -> Result<Vec<SurfaceVerdict>, Error> {
        let centred = self.unseen.holds.iter().filter(|h| h.place_m[0].hypot(h.place_m[1]) < CENTRED_M);
        let unseen = centred.filter_map(|h| Some((h.depth_m, Some(h.surface.as_ref()?))));
        let known = self.fitted_m.iter().filter(|d| self.known.displacement_m(**d, [0.0; 2]).is_some());
        let mut depths: Vec<(f64, Option<&SurfaceGrid>)> = unseen.chain(known.map(|d| (*d, None))).collect();
        depths.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (site_m, probe): (Vector, _) = (session.patch.site_m().cast(), &session.params.probe);
        let reach_m = AROUND * f64::from(probe.radius_m);
        let rest_m: Vec<Vector> = session.patch.mesh().nodes_m.iter().map(|node_m| Vector::from(*node_m)).collect();
        let top: Vec<usize> = (0..rest_m.len())
            .filter(|n| {
                let offset = rest_m[*n] - site_m;
                offset.z.abs() < TOP_M && offset.norm() <= reach_m
            })
            .collect();
        let depths_m: Vec<f64> = depths.iter().map(|d| d.0).collect();
        let mut verdicts = Vec::new();
        settled.press_seen(Vector::zeros(), &depths_m, |hold, tip_m, state| {
            let (depth_m, grid) = depths[hold];
            let off = |n: &usize| {
                let rest_m = rest_m[*n];
                let at = [rest_m.x - site_m.x, rest_m.y - site_m.y];
                let wanted = grid.map_or_else(|| self.known.displacement_m(depth_m, at), |grid| grid.at_m(at))?;
                let face_m = outer_face_m(probe, tip_m.cast(), state.nodes()[*n].position_m().cast());
                Some((face_m - rest_m - Vector::from(wanted)).norm() * 1e3)
            };
            let off_mm: Vec<f64> = top.iter().filter_map(off).collect();
            if !off_mm.is_empty() {
                verdicts.push(SurfaceVerdict {
                    depth_mm: depth_m * 1e3,
                    fitted_depth: grid.is_none(),
                    mean_mm: off_mm.iter().sum::<f64>() / off_mm.len() as f64,
                    most_mm: off_mm.iter().copied().fold(0.0, f64::max),
                });
            }
        })?;
        Ok(verdicts)
    }
}
