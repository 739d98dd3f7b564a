//! Measures the accuracy of a patch with the static solution of its tick: centred presses, random
//! places over a disc, dents, and discs glued to the surface.

use palpate::Params;
use rayon::prelude::*;
use serde::Serialize;

use super::places::random;
use super::targets::Reference;
use crate::pressed_patch::{PressedPatch, error_pct, rms, worst};
use crate::statics::{Balance, Statics, Unbalanced, Vector};
use palpate_tissue::patch::Patch;

/// Depths of the centred presses, both fitted and held out, and depths over the disc [probe radii]:
/// 0.5, 1, .. mm for a radius of 8 mm.
const CENTRED_RADII: [f64; 8] = [0.0625, 0.125, 0.1875, 0.25, 0.375, 0.5, 0.75, 1.0];
const DISC_DEPTHS_RADII: [f64; 7] = [0.0625, 0.125, 0.1875, 0.25, 0.375, 0.5, 0.75];
/// Number of places at which a patch is evaluated.
pub const PLACES: usize = 40;
/// Radius of the disc of places on a whole block [probe radii], and the seed of the places, which
/// no fit uses.
pub const DISC_RADII: f64 = 1.5;
const SEED: u64 = 2026;
/// Depths at which dents are compared, and radius around the site within which they are [probe
/// radii].
const DENTS_RADII: [f64; 2] = [0.25, 0.5];
const DENT_AROUND: f64 = 2.5;

/// Errors of the force at one depth.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct DepthError {
    /// Depth [mm].
    pub depth_mm: f64,
    /// Error of a centred press [%].
    pub centred_pct: f64,
    /// Root mean square of the error over the places [%].
    pub disc_rms_pct: Option<f64>,
    /// Largest error over the places, with its sign [%].
    pub disc_worst_pct: Option<f64>,
}

/// Distances between the surface nodes and the reference at one depth.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct DentError {
    /// Depth [mm].
    pub depth_mm: f64,
    /// Mean distance between the surface and the reference at the nodes [mm]. At a node inside the
    /// probe, the surface is the outer face of the foundation.
    pub surface_mean_mm: f64,
    /// Mean distance of the nodes themselves from the reference [mm].
    pub nodes_mean_mm: f64,
    /// Largest distance of the surface from the reference [mm].
    pub surface_max_mm: f64,
}

/// Error of a disc that is glued to the surface and moved slightly.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct GluedError {
    /// Centre of the disc [mm].
    pub place_mm: [f64; 3],
    /// Radius of the disc [mm].
    pub radius_mm: f64,
    /// Direction of the disc's motion, a unit vector.
    pub direction: [f64; 3],
    /// Error of the disc's force [%].
    pub error_pct: f64,
}

/// All errors of one patch.
#[derive(Clone, Debug, Serialize)]
pub struct Accuracy {
    /// Errors of the force, one entry per depth.
    pub forces: Vec<DepthError>,
    /// Errors of the dented surface, one entry per depth.
    pub dents: Vec<DentError>,
    /// Errors of the glued discs; empty if the reference has none.
    pub glued: Vec<GluedError>,
}

impl Accuracy {
    /// Presses a patch at the centre and at `places` random places within `disc_radii` probe radii.
    ///
    /// # Errors
    /// Fails if a press has no equilibrium.
    pub fn of(
        patch: &Patch,
        params: &Params,
        reference: &(impl Reference + ?Sized),
        disc_radii: f64,
        places: usize,
    ) -> Result<Self, Unbalanced> {
        let pressed = PressedPatch::of(patch, params)?;
        let PressedPatch { statics, solver, site_m, .. } = &pressed;
        let (site_m, radius_m) = (*site_m, f64::from(params.probe.radius_m));
        let deepest_m = reference.deepest_m() * (1.0 + 1e-9);
        let known = |radii: &'static [f64]| radii.iter().map(move |d| d * radius_m).filter(move |d| *d <= deepest_m);
        let error = |offset_m: Vector, depth_m: f64, force: f64| {
            reference.force(offset_m, depth_m).map(|wanted| error_pct(force, wanted))
        };
        let centred = pressed.press(Vector::zeros(), known(&CENTRED_RADII), |depth_m, here| (depth_m, here.clone()))?;
        let over_disc: Vec<Vec<Option<f64>>> = random(places, disc_radii * radius_m, SEED)
            .into_par_iter()
            .map(|[x, y]| {
                let Some(offset_m) = reference.place_m([x, y]) else { return Ok(Vec::new()) };
                pressed.press(offset_m, known(&DISC_DEPTHS_RADII), |depth_m, here| error(offset_m, depth_m, here.force))
            })
            .collect::<Result<_, Unbalanced>>()?;
        let mut forces = Vec::new();
        for at in &centred {
            let column = DISC_DEPTHS_RADII.iter().position(|d| (d * radius_m - at.0).abs() < 1e-9);
            let disc: Option<Vec<f64>> = column.and_then(|c| over_disc.iter().map(|e| e.get(c).copied().flatten()).collect());
            forces.push(DepthError {
                depth_mm: at.0 * 1e3,
                centred_pct: error(Vector::zeros(), at.0, at.1.force).unwrap_or(f64::NAN),
                disc_rms_pct: disc.as_deref().map(rms),
                disc_worst_pct: disc.as_deref().map(worst),
            });
        }
        let dent = |at: &(f64, Balance)| dent(statics, at, site_m, radius_m, reference);
        let dented = centred.iter().filter(|at| DENTS_RADII.iter().any(|d| (d * radius_m - at.0).abs() < 1e-9));
        let glued = reference.glued().iter().map(|disc| {
            let place_m = site_m + Vector::from(disc.place_m);
            let found = solver.glued(statics, place_m, disc.radius_m, disc.direction.into())?;
            Ok(GluedError {
                place_mm: disc.place_m.map(|c| c * 1e3),
                radius_mm: disc.radius_m * 1e3,
                direction: disc.direction,
                error_pct: error_pct(found.stiffness_m, disc.stiffness_over_e_m),
            })
        });
        let glued = glued.collect::<Result<_, Unbalanced>>()?;
        Ok(Self { forces, dents: dented.filter_map(dent).collect(), glued })
    }

    /// Root mean square of the centred errors at `depths_mm` [%].
    #[must_use]
    pub fn centred_rms_pct(&self, depths_mm: &[f64]) -> f64 {
        rms(&self.at(depths_mm).map(|f| f.centred_pct).collect::<Vec<_>>())
    }

    /// Root mean square of the error over places and depths, and the largest error with its sign
    /// [%].
    #[must_use]
    pub fn disc_pct(&self, depths_mm: &[f64]) -> (f64, f64) {
        let of = |pick: fn(&DepthError) -> Option<f64>| self.at(depths_mm).filter_map(pick).collect::<Vec<_>>();
        (rms(&of(|f| f.disc_rms_pct)), worst(&of(|f| f.disc_worst_pct)))
    }

    fn at<'a>(&'a self, depths_mm: &'a [f64]) -> impl Iterator<Item = &'a DepthError> {
        self.forces.iter().filter(|f| depths_mm.iter().any(|d| (d - f.depth_mm).abs() < 1e-6))
    }
}

fn dent(
    statics: &Statics,
    (depth_m, balance): &(f64, Balance),
    site_m: Vector,
    radius_m: f64,
    reference: &(impl Reference + ?Sized),
) -> Option<DentError> {
    let top = statics.rest_m.iter().enumerate().filter(|(_, x)| (x.z - site_m.z).abs() < 1e-9);
    let near = top.filter(|(_, x)| (*x - site_m).norm() <= DENT_AROUND * radius_m);
    let (mut surface, mut nodes) = (Vec::new(), Vec::new());
    for (n, rest) in near {
        let offset = rest - site_m;
        let wanted = rest + Vector::from(reference.displacement_m(*depth_m, [offset.x, offset.y])?);
        surface.push((balance.surface_m(statics, n) - wanted).norm() * 1e3);
        nodes.push((balance.x_m[n] - wanted).norm() * 1e3);
    }
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    Some(DentError {
        depth_mm: depth_m * 1e3,
        surface_mean_mm: mean(&surface),
        nodes_mean_mm: mean(&nodes),
        surface_max_mm: surface.iter().copied().fold(0.0, f64::max),
    })
}
