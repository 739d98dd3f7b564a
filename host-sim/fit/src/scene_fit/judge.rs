//! Force error of a patch at unseen places and depths.

mod glued;
mod surface;

pub use glued::GluedVerdict;
pub use surface::SurfaceVerdict;

use palpate::Params;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::calibrate::places::random;
use crate::calibrate::targets::Reference;
use crate::pressed_patch::{NOT_BEGUN, PressedPatch, error_pct, larger, rms, worst};
use crate::statics::{Balance, Unbalanced};
use palpate_tissue::answer::Answer;
use palpate_tissue::patch::Patch;

/// Number of random places over the disc at which interpolated forces are compared, in addition to
/// the unseen presses, and their seed, which no fit uses.
const PLACES: usize = 40;
const SEED: u64 = 2026;

/// Errors at one depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DepthVerdict {
    /// Depth [mm].
    pub depth_mm: f64,
    /// Whether this depth was in the fit; the places never were.
    pub fitted_depth: bool,
    /// Error of a centred press [%].
    pub centred_pct: f64,
    /// Root mean square error over places [%].
    pub rms_pct: f64,
    /// Largest error over places, with its sign [%].
    pub worst_pct: f64,
}

/// Errors of a patch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Errors at each depth, shallow first.
    pub depths: Vec<DepthVerdict>,
    /// Root mean square error of the presses that were solved by finite elements at places or
    /// depths that the fit did not see [%].
    pub unseen_rms_pct: f64,
    /// The largest of these errors, with its sign [%].
    pub unseen_worst_pct: f64,
    /// Number of presses that the fit did not see.
    pub unseen_presses: usize,
    /// Root mean square over random places of the disc at all depths, between solved places [%].
    pub disc_rms_pct: f64,
    /// The largest of these errors, with its sign [%].
    pub disc_worst_pct: f64,
    /// Number of random places of the disc.
    pub disc_places: usize,
    /// Places that could not be evaluated because the patch has no equilibrium there.
    pub lost_places: usize,
    /// Radius of the disc [m].
    pub disc_radius_m: f64,
    /// Surfaces of centred presses, shallow first, if the finite elements have them.
    pub surfaces: Vec<SurfaceVerdict>,
    /// Glued discs, if the finite elements have them.
    pub glued: Option<GluedVerdict>,
}

impl Verdict {
    /// The larger root mean square [%].
    #[must_use]
    pub fn rms_pct(&self) -> f64 {
        self.unseen_rms_pct.max(self.disc_rms_pct)
    }

    /// The larger worst error, with its sign [%].
    #[must_use]
    pub fn worst_pct(&self) -> f64 {
        larger(self.unseen_worst_pct, self.disc_worst_pct)
    }
}

/// Finite elements for the evaluation of a patch.
#[derive(Clone, Copy)]
pub struct Judging<'a> {
    /// Forces between the places and depths of the fit.
    pub known: &'a dyn Reference,
    /// Depths of the fit [m].
    pub fitted_m: &'a [f64],
    /// Unseen presses; places are relative to the site.
    pub unseen: &'a Answer,
    /// Radius of the disc of places [probe radii].
    pub disc_radii: f64,
}

impl Judging<'_> {
    /// Presses a patch, at rest on its own site, as in the unseen presses and over the disc. A
    /// place off the centre without equilibrium is counted and not evaluated.
    ///
    /// # Errors
    /// A press at the centre has no equilibrium.
    pub fn judge(&self, patch: &Patch, params: &Params) -> Result<Verdict, Unbalanced> {
        let pressed = PressedPatch::of(patch, params)?;
        let mut places: Vec<[f64; 3]> = Vec::new();
        for hold in &self.unseen.holds {
            if !places.contains(&hold.place_m) {
                places.push(hold.place_m);
            }
        }
        let asked = places.len() + PLACES;
        // the centre must have an equilibrium; under a flat end a place off it may not
        let direct: Vec<Vec<(f64, f64)>> =
            places.into_par_iter().filter_map(|at| self.errors_of_unseen(&pressed, at).ok()).collect();
        // depths of the answers; a place has some of them
        let mut depths_m: Vec<f64> = self.unseen.holds.iter().map(|h| h.depth_m).chain(self.fitted_m.iter().copied()).collect();
        depths_m.sort_by(f64::total_cmp);
        depths_m.dedup();
        let radius_m = self.disc_radii * f64::from(params.probe.radius_m);
        let over_disc = |at: [f64; 2]| self.errors_of_known(&pressed, &depths_m, at);
        let disc: Vec<Vec<f64>> = random(PLACES, radius_m, SEED).into_par_iter().filter_map(|at| over_disc(at).ok()).collect();
        let lost_places = asked - direct.len() - disc.len();
        let direct: Vec<(f64, f64)> = direct.into_iter().flatten().collect();
        let errors: Vec<f64> = direct.iter().map(|(_, e)| *e).collect();
        let all: Vec<f64> = disc.iter().flatten().copied().collect();
        Ok(Verdict {
            depths: by_depth(&depths_m, self.fitted_m, &direct, &disc, &over_disc([0.0; 2])?),
            unseen_rms_pct: rms(&errors),
            unseen_worst_pct: worst(&errors),
            unseen_presses: errors.len(),
            disc_rms_pct: rms(&all),
            disc_worst_pct: worst(&all),
            disc_places: disc.len(),
            lost_places,
            disc_radius_m: radius_m,
            surfaces: self.surfaces(&pressed)?,
            glued: self.glued(&pressed)?,
        })
    }

    /// Depth [m] and force error [%] of every unseen press at a place.
    fn errors_of_unseen(&self, pressed: &PressedPatch, at_m: [f64; 3]) -> Result<Vec<(f64, f64)>, Unbalanced> {
        let here = self.unseen.holds.iter().filter(|h| h.place_m == at_m);
        let mut holds: Vec<(f64, f64)> = here.map(|h| (h.depth_m, h.force_over_e_m2)).collect();
        holds.sort_by(|a, b| a.0.total_cmp(&b.0));
        let forces = pressed.press(at_m.into(), holds.iter().map(|h| h.0), |_, here| here.force)?;
        Ok(holds.iter().zip(forces).map(|((depth_m, wanted), force)| (*depth_m, error_pct(force, *wanted))).collect())
    }

    /// Force errors [%] at a place against what is known between solved places, shape \[depths\].
    fn errors_of_known(&self, pressed: &PressedPatch, depths_m: &[f64], place_m: [f64; 2]) -> Result<Vec<f64>, Unbalanced> {
        let offset_m = self.known.place_m(place_m).ok_or(NOT_BEGUN)?;
        let error = |depth_m, here: &Balance| {
            self.known.force(offset_m, depth_m).map(|wanted| error_pct(here.force, wanted)).ok_or(NOT_BEGUN)
        };
        pressed.press(offset_m, depths_m.iter().copied(), error)?.into_iter().collect()
    }
}

/// Errors by depth. The error at the centre is that of the press that was solved there, if there is
/// one.
fn by_depth(depths_m: &[f64], fitted_m: &[f64], direct: &[(f64, f64)], disc: &[Vec<f64>], centred: &[f64]) -> Vec<DepthVerdict> {
    let at_depth = |(n, depth_m): (usize, &f64)| {
        let column: Vec<f64> = disc.iter().filter_map(|row| row.get(n).copied()).collect();
        let fitted_depth = fitted_m.contains(depth_m);
        // the centre is the first of the unseen presses
        let solved = direct.iter().find(|(depth, _)| depth == depth_m && !fitted_depth).map(|(_, error)| *error);
        let between = centred.get(n).copied().unwrap_or(f64::NAN);
        DepthVerdict {
            depth_mm: depth_m * 1e3,
            fitted_depth,
            centred_pct: solved.unwrap_or(between),
            rms_pct: rms(&column),
            worst_pct: worst(&column),
        }
    };
    depths_m.iter().enumerate().map(at_depth).collect()
}
