//! How wrong a patch is where the fit has not looked.

use palpate::Params;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::known::Known;
use super::presses::JUDGED_RADII;
use crate::calibrate::places::random;
use crate::calibrate::targets::Reference;
use crate::statics::{Balance, CLEAR_M, Solver, Statics, Unbalanced, Vector};
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
    /// By depth.
    pub depths: Vec<DepthVerdict>,
    /// Root mean square and the largest, of the presses that were solved by finite elements at
    /// places or depths that the fit did not see [%].
    pub unseen_rms_pct: f64,
    /// The largest of them, with its sign [%].
    pub unseen_worst_pct: f64,
    /// How many they are.
    pub unseen_presses: usize,
    /// Root mean square over random places of the disc at all depths, between solved places [%].
    pub disc_rms_pct: f64,
    /// The largest of them, with its sign [%].
    pub disc_worst_pct: f64,
    /// How many places.
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
    faer::set_global_parallelism(faer::Par::Seq);
    let refused = Unbalanced { depth_mm: 0.0, steps: 0 };
    let statics = Statics::of(&patch.model(), params).map_err(|_| refused)?;
    let solver = Solver::of(&statics).ok_or(refused)?;
    let site_m: Vector = patch.site_m().cast();
    let rest = solver.rest(&statics, site_m, CLEAR_M)?;
    let radius_m = f64::from(params.probe.radius_m);
    let press = |offset_m: Vector, depths_m: &[f64]| -> Result<Vec<f64>, Unbalanced> {
        let place_m = site_m + offset_m;
        let mut here: Balance = rest.with_tip(place_m + statics.axis() * CLEAR_M);
        let mut forces = Vec::with_capacity(depths_m.len());
        for depth_m in depths_m {
            here = solver.press(&statics, &here, place_m - statics.axis() * *depth_m, *depth_m)?;
            forces.push(here.force);
        }
        Ok(forces)
    };
    // depths of the answers; a place knows some of them
    let fitted_m = known.depths_m();
    let mut depths_m: Vec<f64> = unseen.holds.iter().map(|h| h.depth_m).chain(fitted_m.iter().copied()).collect();
    depths_m.sort_by(f64::total_cmp);
    depths_m.dedup();
    let mut places: Vec<[f64; 2]> = Vec::new();
    for hold in &unseen.holds {
        let at = [hold.place_m[0], hold.place_m[1]];
        if !places.contains(&at) {
            places.push(at);
        }
    }
    let solved = |at: [f64; 2]| -> Result<Vec<(f64, f64)>, Unbalanced> {
        let mut holds: Vec<(f64, f64)> =
            unseen.holds.iter().filter(|h| [h.place_m[0], h.place_m[1]] == at).map(|h| (h.depth_m, h.force_over_e_m2)).collect();
        holds.sort_by(|a, b| a.0.total_cmp(&b.0));
        let forces = press(Vector::new(at[0], at[1], 0.0), &holds.iter().map(|h| h.0).collect::<Vec<_>>())?;
        Ok(holds.iter().zip(forces).map(|((depth_m, wanted), force)| (*depth_m, 100.0 * (force / wanted - 1.0))).collect())
    };
    let asked = places.len() + PLACES;
    // the centre has to balance; under a flat end a place off it may not
    let direct: Vec<Vec<(f64, f64)>> = places.into_par_iter().filter_map(|at| solved(at).ok()).collect();
    let over_disc = |[x, y]: [f64; 2]| -> Result<Vec<f64>, Unbalanced> {
        let offset_m = Vector::new(x, y, 0.0);
        let error = |(force, depth_m): (f64, &f64)| {
            known.force(offset_m, *depth_m).map(|wanted| 100.0 * (force / wanted - 1.0)).ok_or(refused)
        };
        press(offset_m, &depths_m)?.into_iter().zip(&depths_m).map(error).collect()
    };
    let disc: Vec<Vec<f64>> =
        random(PLACES, JUDGED_RADII * radius_m, SEED).into_par_iter().filter_map(|at| over_disc(at).ok()).collect();
    let lost_places = asked - direct.len() - disc.len();
    let direct: Vec<(f64, f64)> = direct.into_iter().flatten().collect();
    let centred = over_disc([0.0; 2])?;
    let depths = depths_m.iter().enumerate().map(|(n, depth_m)| {
        let column: Vec<f64> = disc.iter().map(|row| row[n]).collect();
        let own = unseen.hold([0.0; 3], *depth_m);
        let centred_pct = match own {
            Some(hold) => direct_error(&direct, hold.depth_m).unwrap_or(centred[n]),
            None => centred[n],
        };
        DepthVerdict {
            depth_mm: depth_m * 1e3,
            fitted_depth: fitted_m.contains(depth_m),
            centred_pct,
            rms_pct: rms(&column),
            worst_pct: worst(&column),
        }
    });
    let errors: Vec<f64> = direct.iter().map(|(_, e)| *e).collect();
    let all: Vec<f64> = disc.iter().flatten().copied().collect();
    Ok(Verdict {
        depths: depths.collect(),
        unseen_rms_pct: rms(&errors),
        unseen_worst_pct: worst(&errors),
        unseen_presses: errors.len(),
        disc_rms_pct: rms(&all),
        disc_worst_pct: worst(&all),
        disc_places: disc.len(),
        lost_places,
        disc_radius_m: JUDGED_RADII * radius_m,
    })
}

/// Of the centre, which is the first of the unseen presses.
fn direct_error(direct: &[(f64, f64)], depth_m: f64) -> Option<f64> {
    direct.iter().find(|(depth, _)| *depth == depth_m).map(|(_, error)| *error)
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt()
}

fn worst(errors: &[f64]) -> f64 {
    errors.iter().copied().fold(0.0, larger)
}

fn larger(a: f64, b: f64) -> f64 {
    if b.abs() > a.abs() { b } else { a }
}
