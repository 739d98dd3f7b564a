//! The patch of a block and what it is fitted to.

use palpate::Params;

use super::known::Known;
use super::presses::{DENTS, Presses};
use crate::calibrate::targets::{DISC_RADII, DiscPresses};
use crate::calibrate::{Calibration, Round, Settings, Targets, calibrate};
use crate::statics::Vector;
use palpate_tissue::error::Error;
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::scene::Scene;
use palpate_tissue::tissue::{Tissue, place_fine};

/// Elements under the probe are smallest this far around it [probe radii].
pub const FINE_RADII: f64 = 1.25;
/// Elements larger than this share of the probe's radius get nine foundation points per triangle
/// instead of four.
const NINE_ABOVE: f64 = 0.4;
/// Places that can be asked for: 20 over-fit.
pub const PLACES_RANGE: std::ops::RangeInclusive<usize> = 20..=2000;
/// A force this far off counts as one unit of error (1); the shallowest rests on few points and may
/// be further off.
const TOLERANCE: f64 = 0.005;
const SHALLOW_TOLERANCE: f64 = 0.008;
/// The shallowest depths, which rest on few points, are fitted at so many times more places.
const SHALLOW_DEPTHS: usize = 2;
const SHALLOW_PLACES: usize = 2;

/// A scene's patch before the fit.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Meshed tissue.
    pub tissue: Tissue,
    /// Constants of the material.
    pub material: Material,
    /// Parameters of the scene.
    pub params: Params,
}

/// Nodes on the top of a block, and their places [m].
#[must_use]
pub fn top_nodes(tissue: &Tissue) -> Vec<(usize, Vector)> {
    let top = (0..).zip(&tissue.mesh.nodes_m).filter(|(_, x)| (x[2] - tissue.site_m[2]).abs() < 1e-9);
    top.map(|(n, x)| (n, Vector::from(*x))).collect()
}

/// Meshes the block of a scene for its patch.
///
/// # Errors
/// A block that cannot be meshed so.
pub fn prepare(scene: &Scene) -> Result<Prepared, Error> {
    let placed = place_fine(scene, &[], FINE_RADII)?;
    let params = scene.params(placed.axis);
    let material = Material { poisson_ratio: scene.tissue.poisson_ratio, ..Material::default() };
    let element_m = Patch::build(&placed.tissue, &material, None).element_m();
    let points_per_triangle = if element_m > NINE_ABOVE * scene.probe.radius_m { 9 } else { 4 };
    Ok(Prepared { tissue: placed.tissue, material: Material { points_per_triangle, ..material }, params })
}

impl Prepared {
    /// The patch with constants from formulas alone.
    #[must_use]
    pub fn uncalibrated(&self) -> Patch {
        Patch::build(&self.tissue, &self.material, None)
    }

    /// Fits the patch to what is known.
    ///
    /// # Errors
    /// Presses that the reference lacks, a patch that cannot be pressed, a fit that gains nothing.
    pub fn fit(
        &self,
        scene: &Scene,
        presses: &Presses,
        known: &Known,
        settings: &Settings,
        progress: &mut dyn FnMut(&Round),
    ) -> Result<Calibration, Error> {
        let lacks = || Error::Check(format!("{}: the finite elements lack presses that the fit needs: fit it anew", scene.file));
        let targets = self.targets(presses, known, settings.places).ok_or_else(lacks)?;
        let fit = calibrate(&self.tissue, &self.material, None, &self.params, &targets, settings, progress)
            .map_err(|cause| Error::Usage(format!("{}: {cause}", scene.file)))?;
        if !matches!((fit.rounds.first(), fit.rounds.last()), (Some(first), Some(last)) if last.cost < first.cost) {
            let why = "the fit did not improve the patch, nothing is written: take more --places or another --nodes";
            return Err(Error::Check(why.into()));
        }
        Ok(fit)
    }

    fn targets(&self, presses: &Presses, known: &Known, places: usize) -> Option<Targets> {
        let centre_m = Vector::from(self.tissue.site_m);
        let tolerance = |n: usize| if n == 0 { SHALLOW_TOLERANCE } else { TOLERANCE };
        let depths: Vec<(f64, f64)> = presses.fitted_m.iter().enumerate().map(|(n, depth_m)| (*depth_m, tolerance(n))).collect();
        let shallow = depths.get(..SHALLOW_DEPTHS)?.to_vec();
        let disc = DiscPresses {
            centre: depths.clone(),
            aside: vec![(places, depths), (SHALLOW_PLACES * places, shallow)],
            dents_m: DENTS.iter().map(|n| presses.fitted_m[*n]).collect(),
        };
        Targets::over(known, &top_nodes(&self.tissue), centre_m, f64::from(self.params.probe.radius_m), DISC_RADII, &disc)
    }
}
