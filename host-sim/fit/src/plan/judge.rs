//! Measures the accuracy of a fitted patch at unseen places: presses at random places within one
//! probe radius of the site, at the scene's depths.

use palpate::Params;
use rayon::prelude::*;
use serde::Serialize;

use crate::calibrate::places::random;
use crate::calibrate::targets::Reference;
use crate::far_field::fitted::{JUDGED_PLACES, JUDGED_RADII, deepest_hold_m};
use crate::pressed_patch::{NOT_BEGUN, PressedPatch, error_pct, larger, rms, worst};
use crate::statics::{Balance, Unbalanced, Vector};
use palpate_tissue::error::Error;
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::{Drive, Scene};
use palpate_tissue::tissue::DEPTH_MARGIN;

/// Largest allowed error at a single place, as a multiple of the tolerance (1).
pub const WORST_RATIO: f64 = 2.5;
/// Depths that are evaluated in addition to the holds, as far as they are less than the deepest
/// hold [probe radii]. The first is the shallowest for which accuracy is promised.
const DEPTHS_RADII: [f64; 8] = [0.125, 0.1875, 0.25, 0.375, 0.5, 0.75, 1.0, 1.25];
/// Relative difference up to which two depths count as equal (1).
const SAME: f64 = 0.02;

/// Depths at which the patch of a scene is evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct Judge {
    /// Depths in ascending order [m].
    pub depths_m: Vec<f64>,
}

/// Force errors of a patch [%].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Judged {
    /// Root mean square over places and depths [%]; with several sets of places, the largest of
    /// them.
    pub rms_pct: f64,
    /// Largest single error, with its sign [%].
    pub worst_pct: f64,
    /// Root mean square of the centred presses [%].
    pub centred_rms_pct: f64,
    /// Largest error of the centred presses, with its sign [%].
    pub centred_worst_pct: f64,
    /// Number of evaluated places.
    pub places: usize,
}

impl Judged {
    /// The tightest tolerance that these errors meet [%].
    #[must_use]
    pub fn keeps_pct(&self) -> f64 {
        let worst = self.worst_pct.abs().max(self.centred_worst_pct.abs());
        self.rms_pct.max(self.centred_rms_pct).max(worst / WORST_RATIO)
    }
}

impl Judge {
    /// The holds of the scene, and smaller depths down to an eighth of the probe's radius.
    ///
    /// # Errors
    /// Fails if the reference lacks a hold.
    pub fn of(scene: &Scene, depth_limit_m: f64, reference: &dyn Reference) -> Result<Self, Error> {
        let radius_m = scene.probe.radius_m;
        let deepest_m = deepest_hold_m(scene).unwrap_or(depth_limit_m / DEPTH_MARGIN);
        let holds_m = match &scene.drive {
            Drive::Depth { holds_m, .. } | Drive::Hand { holds_m, .. } => holds_m.clone(),
            _ => vec![deepest_m],
        };
        for hold_m in &holds_m {
            if reference.force(Vector::zeros(), *hold_m).is_none() {
                let known = [reference.shallowest_m(), reference.deepest_m()].map(|d| d * 1e3);
                return Err(Error::Usage(format!(
                    "{}: drive.holds_m: the reference knows no press {:.3} mm deep, only {:.3} to {:.3} mm: hold there",
                    scene.file,
                    hold_m * 1e3,
                    known[0],
                    known[1]
                )));
            }
        }
        let mut depths_m = holds_m;
        for depth_m in DEPTHS_RADII.map(|r| r * radius_m) {
            let apart = depths_m.iter().all(|d| (d / depth_m - 1.0).abs() > SAME);
            if apart && depth_m < deepest_m && depth_m >= reference.shallowest_m() {
                depths_m.push(depth_m);
            }
        }
        depths_m.sort_by(f64::total_cmp);
        depths_m.dedup();
        Ok(Self { depths_m })
    }

    /// Presses a patch at the centre and at [`JUDGED_PLACES`] random places of each seed.
    ///
    /// # Errors
    /// Fails if a press has no equilibrium.
    pub fn judge(&self, patch: &Patch, params: &Params, reference: &dyn Reference, seeds: &[u64]) -> Result<Judged, Unbalanced> {
        let pressed = PressedPatch::of(patch, params)?;
        let errors_at = |offset_m: Vector| -> Result<Vec<f64>, Unbalanced> {
            let error = |depth_m, here: &Balance| {
                reference.force(offset_m, depth_m).map(|wanted| error_pct(here.force, wanted)).ok_or(NOT_BEGUN)
            };
            pressed.press(offset_m, self.depths_m.iter().copied(), error)?.into_iter().collect()
        };
        let centred = errors_at(Vector::zeros())?;
        let (mut rms_pct, mut worst_pct, mut places) = (0.0_f64, 0.0, 0);
        for seed in seeds {
            let offsets = random(JUDGED_PLACES, JUDGED_RADII * f64::from(params.probe.radius_m), *seed);
            // a place beyond the surface of the organ is skipped
            let offsets: Vec<Vector> = offsets.into_iter().filter_map(|xy| reference.place_m(xy)).collect();
            let errors = offsets.into_par_iter().map(errors_at).collect::<Result<Vec<_>, _>>()?;
            places += errors.len();
            let all: Vec<f64> = errors.into_iter().flatten().collect();
            rms_pct = rms_pct.max(rms(&all));
            worst_pct = larger(worst_pct, worst(&all));
        }
        Ok(Judged { rms_pct, worst_pct, centred_rms_pct: rms(&centred), centred_worst_pct: worst(&centred), places })
    }
}
