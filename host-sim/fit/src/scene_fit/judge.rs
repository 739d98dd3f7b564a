//! Force error of a patch at places and depths that its fit has not seen.

use palpate::Params;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::known::Known;
use super::presses::JUDGED_RADII;
use crate::calibrate::places::random;
use crate::calibrate::targets::Reference;
use crate::pressed_patch::{NOT_BEGUN, PressedPatch, error_pct, larger, rms, worst};
use crate::statics::{Balance, Unbalanced, Vector};
use palpate_tissue::answer::Answer;
use palpate_tissue::patch::Patch;

/// Random places over the disc at which the known forces are asked for, beside the unseen presses,
/// and the seed of them, which no fit uses.
const PLACES: usize = 40;
const SEED: u64 = 2026;

/// Errors at one depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DepthVerdict {
    /// Depth [mm].
    pub depth_mm: f64,
    /// Whether the fit knew this depth; its places it never knew.
    pub fitted_depth: bool,
    /// Error of a centred press [%].
    pub centred_pct: f64,
    /// Root mean square over places [%].
    pub rms_pct: f64,
    /// The largest, with its sign [%].
    pub worst_pct: f64,
}

/// Errors of a patch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Errors at each depth, shallow first.
    pub depths: Vec<DepthVerdict>,
    /// Root mean square and the largest, of the presses that were solved by finite elements at
    /// places or depths that the fit did not see [%].
    pub unseen_rms_pct: f64,
    /// The largest of them, with its sign [%].
    pub unseen_worst_pct: f64,
    /// Count of those presses.
    pub unseen_presses: usize,
    /// Root mean square over random places of the disc at all depths, between solved places [%].
    pub disc_rms_pct: f64,
    /// The largest of them, with its sign [%].
    pub disc_worst_pct: f64,
    /// Count of those places.
    pub disc_places: usize,
    /// Places that could not be judged: the patch finds no balance there.
    pub lost_places: usize,
    /// Radius of the disc [m].
    pub disc_radius_m: f64,
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

/// Presses a patch, at rest on its own site, as `unseen` was pressed, and over the disc. A place
/// off the centre without balance is counted, and not judged.
///
/// # Errors
/// A press at the centre without balance.
pub fn judge(patch: &Patch, params: &Params, known: &Known, unseen: &Answer) -> Result<Verdict, Unbalanced> {
    let pressed = PressedPatch::of(patch, params)?;
    let mut places: Vec<[f64; 2]> = Vec::new();
    for hold in &unseen.holds {
        let at = [hold.place_m[0], hold.place_m[1]];
        if !places.contains(&at) {
            places.push(at);
        }
    }
    let asked = places.len() + PLACES;
    // the centre has to balance; under a flat end a place off it may not
    let direct: Vec<Vec<(f64, f64)>> =
        places.into_par_iter().filter_map(|at| errors_of_unseen(&pressed, unseen, at).ok()).collect();
    // depths of the answers; a place knows some of them
    let mut depths_m: Vec<f64> = unseen.holds.iter().map(|h| h.depth_m).chain(known.depths_m()).collect();
    depths_m.sort_by(f64::total_cmp);
    depths_m.dedup();
    let radius_m = JUDGED_RADII * f64::from(params.probe.radius_m);
    let over_disc = |at: [f64; 2]| errors_of_known(&pressed, known, &depths_m, at);
    let disc: Vec<Vec<f64>> = random(PLACES, radius_m, SEED).into_par_iter().filter_map(|at| over_disc(at).ok()).collect();
    let lost_places = asked - direct.len() - disc.len();
    let direct: Vec<(f64, f64)> = direct.into_iter().flatten().collect();
    let errors: Vec<f64> = direct.iter().map(|(_, e)| *e).collect();
    let all: Vec<f64> = disc.iter().flatten().copied().collect();
    Ok(Verdict {
        depths: by_depth(&depths_m, known, &direct, &disc, &over_disc([0.0; 2])?),
        unseen_rms_pct: rms(&errors),
        unseen_worst_pct: worst(&errors),
        unseen_presses: errors.len(),
        disc_rms_pct: rms(&all),
        disc_worst_pct: worst(&all),
        disc_places: disc.len(),
        lost_places,
        disc_radius_m: radius_m,
    })
}

/// Depth [m] and force error [%] of every unseen press at a place.
fn errors_of_unseen(pressed: &PressedPatch, unseen: &Answer, at: [f64; 2]) -> Result<Vec<(f64, f64)>, Unbalanced> {
    let mut holds: Vec<(f64, f64)> =
        unseen.holds.iter().filter(|h| [h.place_m[0], h.place_m[1]] == at).map(|h| (h.depth_m, h.force_over_e_m2)).collect();
    holds.sort_by(|a, b| a.0.total_cmp(&b.0));
    let forces = pressed.press(Vector::new(at[0], at[1], 0.0), holds.iter().map(|h| h.0), |_, here| here.force)?;
    Ok(holds.iter().zip(forces).map(|((depth_m, wanted), force)| (*depth_m, error_pct(force, *wanted))).collect())
}

/// Force errors [%] at a place against what is known between solved places, shape \[depths\].
fn errors_of_known(pressed: &PressedPatch, known: &Known, depths_m: &[f64], [x, y]: [f64; 2]) -> Result<Vec<f64>, Unbalanced> {
    let offset_m = Vector::new(x, y, 0.0);
    let error =
        |depth_m, here: &Balance| known.force(offset_m, depth_m).map(|wanted| error_pct(here.force, wanted)).ok_or(NOT_BEGUN);
    pressed.press(offset_m, depths_m.iter().copied(), error)?.into_iter().collect()
}

/// Errors by depth; of the centre the press that was solved there, where there is one.
fn by_depth(depths_m: &[f64], known: &Known, direct: &[(f64, f64)], disc: &[Vec<f64>], centred: &[f64]) -> Vec<DepthVerdict> {
    let fitted_m = known.depths_m();
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
