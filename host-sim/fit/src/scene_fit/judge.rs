//! Measures the force error of a patch at unseen places and depths, through ticks of the core as a
//! device runs them: every error that is stated of a patch comes from here.

mod glued;
mod surface;

pub use glued::GluedVerdict;
use surface::CENTRED_M;
pub use surface::SurfaceVerdict;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::calibrate::places::random;
use crate::calibrate::targets::Reference;
use crate::calibrate::too_many_lost;
use crate::force_map::BlockForces;
use crate::pressed_patch::{error_pct, larger, rms, worst};
use crate::settled::{Settled, SettledPatch};
use crate::statics::Vector;
use palpate_tissue::answer::Answer;
use palpate_tissue::error::Error;
use palpate_tissue::fit_record::{FitRecord, Judged, JudgedPart, JudgedSurface};
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;

/// Number of random places over the disc at which forces are usually compared with interpolated
/// ones, in addition to the unseen presses, and the seed of the places, which no fit uses.
pub const PLACES: usize = 40;
const SEED: u64 = 2026;
/// Difference below which two depths count as the same [m].
const SAME_M: f64 = 1e-7;
/// Largest allowed error of a single press, as a multiple of the tolerance (1).
pub const WORST_RATIO: f64 = 2.5;

/// Errors at one depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DepthVerdict {
    /// Depth [mm].
    pub depth_mm: f64,
    /// Whether this depth was in the fit; the places were not.
    pub fitted_depth: bool,
    /// Error of a centred press [%].
    pub centred_pct: f64,
    /// Root mean square error over places [%].
    pub rms_pct: f64,
    /// Largest error over places, with its sign [%].
    pub worst_pct: f64,
}

/// Errors of a patch at unseen presses, over the disc of places, on its surface and under glued
/// discs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Errors at each depth, in ascending order.
    pub depths: Vec<DepthVerdict>,
    /// Root mean square error of the presses that finite elements solved at places or depths
    /// outside the fit [%].
    pub unseen_rms_pct: f64,
    /// Largest of these errors, with its sign [%].
    pub unseen_worst_pct: f64,
    /// Number of evaluated presses at places or depths outside the fit.
    pub unseen_presses: usize,
    /// Root mean square error over random places of the disc and all depths, compared with forces
    /// interpolated between the solved places [%].
    pub disc_rms_pct: f64,
    /// Largest of these errors, with its sign [%].
    pub disc_worst_pct: f64,
    /// Number of random places of the disc.
    pub disc_places: usize,
    /// Number of presses beyond the depth limit of the patch, whose force is a continuation.
    pub limited_presses: usize,
    /// Number of presses that could not be evaluated because the patch does not come to rest.
    pub lost_presses: usize,
    /// Total number of presses, including those at random places.
    pub presses: usize,
    /// Radius of the disc of places [m].
    pub disc_radius_m: f64,
    /// Error of the finite elements themselves [%].
    #[serde(default)]
    pub reference_pct: f64,
    /// Surface errors of centred presses, in the order of increasing depth, if the finite elements
    /// have surfaces.
    pub surfaces: Vec<SurfaceVerdict>,
    /// Errors of the glued discs, if the finite elements have such discs.
    pub glued: Option<GluedVerdict>,
}

impl Verdict {
    /// The larger of the two root mean squares, with the error of the finite elements, which is
    /// independent of it [%].
    #[must_use]
    pub fn rms_pct(&self) -> f64 {
        self.unseen_rms_pct.max(self.disc_rms_pct).hypot(self.reference_pct)
    }

    /// The larger of the two worst errors, with its sign, and the error of the finite elements on
    /// top [%].
    #[must_use]
    pub fn worst_pct(&self) -> f64 {
        let worst_pct = larger(self.unseen_worst_pct, self.disc_worst_pct);
        worst_pct + self.reference_pct.copysign(worst_pct)
    }

    /// The tightest tolerance that the errors meet [%].
    #[must_use]
    pub fn keeps_pct(&self) -> f64 {
        self.rms_pct().max(self.worst_pct().abs() / WORST_RATIO)
    }

    /// The errors as the record of a patch states them.
    #[must_use]
    pub fn judged(&self) -> Judged {
        let depths_m = || self.depths.iter().map(|at| at.depth_mm * 1e-3);
        Judged {
            rms_pct: self.rms_pct(),
            worst_pct: self.worst_pct(),
            from_m: depths_m().fold(f64::INFINITY, f64::min),
            to_m: depths_m().fold(0.0, f64::max),
            places: self.disc_places,
            lost_presses: self.lost_presses,
            disc_radius_m: self.disc_radius_m,
            bump: None,
            glued: self.glued.map(|glued| JudgedPart { rms_pct: glued.rms_pct, worst_pct: glued.worst_pct }),
            surface: self.surfaces.last().map(|surface| JudgedSurface {
                depth_m: surface.depth_mm * 1e-3,
                mean_m: surface.mean_mm * 1e-3,
                most_m: surface.most_mm * 1e-3,
            }),
        }
    }

    /// Whether so many presses could not be evaluated that the errors say too little.
    #[must_use]
    pub fn lost_too_many(&self) -> bool {
        too_many_lost(self.lost_presses, self.presses)
    }
}

/// Finite-element answers with which a patch is evaluated.
#[derive(Clone, Copy)]
pub struct Judging<'a> {
    /// Reference forces between the places and depths of the fit.
    pub known: &'a dyn Reference,
    /// Depths of the fit [m].
    pub fitted_m: &'a [f64],
    /// Presses outside the fit; places are relative to the site.
    pub unseen: &'a Answer,
    /// Radius of the disc of places [probe radii].
    pub disc_radii: f64,
    /// Number of random places on the disc.
    pub places: usize,
    /// Relative error of the finite elements themselves (1).
    pub reference_error: f64,
}

/// Errors of a packed patch, judged anew between the depths of its record. Without a stored
/// finite-element answer for the scene, the record keeps the errors of its fit: the constants are
/// the same, and a force at rest depends neither on masses nor on substeps.
///
/// # Errors
/// Errors of [`Judging::judge`].
pub fn judged_again(scene: &Scene, session: &Session, record: &FitRecord) -> Result<Judged, Error> {
    let answer = Answer::block();
    let Some(known) = BlockForces::of(&answer).filter(|_| answer.is_for(scene) && record.judged.bump.is_none()) else {
        return Ok(record.judged);
    };
    let depths_m = record.judged.from_m - SAME_M..record.judged.to_m + SAME_M;
    let mut unseen = answer.clone();
    unseen.holds.retain(|hold| hold.place_m == [0.0; 3] && depths_m.contains(&hold.depth_m));
    if record.judged.glued.is_none() {
        unseen.glued.clear();
    }
    let disc_radii = record.judged.disc_radius_m / scene.probe.radius_m;
    let reference_error = 0.01 * record.reference_error_pct.unwrap_or_default();
    let places = record.judged.places;
    let judging = Judging { known: &known, fitted_m: &[], unseen: &unseen, disc_radii, places, reference_error };
    let judged = judging.judge(session)?.judged();
    let surface = judged.surface.filter(|_| record.judged.surface.is_some());
    // as the record has it: the radius of a probe in a session is rounded
    Ok(Judged { surface, disc_radius_m: record.judged.disc_radius_m, ..judged })
}

/// Error of the force of one press.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PressError {
    place_m: [f64; 3],
    depth_m: f64,
    /// Whether the depth limit of the patch acted.
    limited: bool,
    /// Relative error of the force [%]; `None` if the patch does not come to rest there.
    pct: Option<f64>,
}

impl Judging<'_> {
    /// Evaluates the patch of a session in the unseen presses and in presses over the disc of
    /// places.
    ///
    /// # Errors
    /// Fails if the core rejects the model, or if the reference does not know a place of the disc.
    pub fn judge(&self, session: &Session) -> Result<Verdict, Error> {
        let settled = SettledPatch::of(session);
        let mut places: Vec<[f64; 3]> = Vec::new();
        for hold in &self.unseen.holds {
            if !places.contains(&hold.place_m) {
                places.push(hold.place_m);
            }
        }
        let direct: Vec<PressError> =
            places.into_par_iter().map(|at| self.errors_of_unseen(&settled, at)).collect::<Result<Vec<_>, _>>()?.concat();
        // depths of all answers; a single place has only some of them
        let mut depths_m: Vec<f64> = self.unseen.holds.iter().map(|h| h.depth_m).chain(self.fitted_m.iter().copied()).collect();
        depths_m.sort_by(f64::total_cmp);
        depths_m.dedup();
        let radius_m = self.disc_radii * f64::from(session.params.probe.radius_m);
        let over_disc = |at: [f64; 2]| self.errors_of_known(&settled, &depths_m, at);
        let disc: Vec<PressError> =
            random(self.places, radius_m, SEED).into_par_iter().map(over_disc).collect::<Result<Vec<_>, _>>()?.concat();
        let all = || direct.iter().chain(&disc);
        let [unseen_pct, disc_pct] = [&direct, &disc].map(|of| of.iter().filter_map(|press| press.pct).collect::<Vec<f64>>());
        Ok(Verdict {
            depths: by_depth(&depths_m, self.fitted_m, &direct, &disc, &over_disc([0.0; 2])?),
            unseen_rms_pct: rms(&unseen_pct),
            unseen_worst_pct: worst(&unseen_pct),
            unseen_presses: unseen_pct.len(),
            disc_rms_pct: rms(&disc_pct),
            disc_worst_pct: worst(&disc_pct),
            disc_places: self.places,
            limited_presses: all().filter(|press| press.limited).count(),
            lost_presses: all().filter(|press| press.pct.is_none()).count(),
            presses: all().count(),
            disc_radius_m: radius_m,
            reference_pct: 100.0 * self.reference_error,
            surfaces: self.surfaces(&settled, session)?,
            glued: self.glued(session)?,
        })
    }

    /// Errors of all unseen presses at a place, in the order of increasing depth.
    fn errors_of_unseen(&self, settled: &SettledPatch, place_m: [f64; 3]) -> Result<Vec<PressError>, Error> {
        let here = self.unseen.holds.iter().filter(|h| h.place_m == place_m);
        let mut holds: Vec<(f64, f64)> = here.map(|h| (h.depth_m, h.force_over_e_m2)).collect();
        holds.sort_by(|a, b| a.0.total_cmp(&b.0));
        errors(settled, place_m.into(), &holds)
    }

    /// Errors at a place, compared with the forces that are interpolated between solved places,
    /// shape \[depths\].
    fn errors_of_known(&self, settled: &SettledPatch, depths_m: &[f64], place_m: [f64; 2]) -> Result<Vec<PressError>, Error> {
        let unknown = || Error::Check(format!("the finite elements know no force at {place_m:?} m: solve them anew"));
        let offset_m = self.known.place_m(place_m).ok_or_else(unknown)?;
        let wanted = |depth_m: &f64| self.known.force(offset_m, *depth_m).map(|m2| (*depth_m, m2)).ok_or_else(unknown);
        let wanted = depths_m.iter().map(wanted).collect::<Result<Vec<_>, _>>()?;
        errors(settled, offset_m, &wanted)
    }
}

/// Errors at an offset from the site [m], for pairs of a depth [m] and its required force over E
/// [m^2].
fn errors(settled: &SettledPatch, offset_m: Vector, wanted: &[(f64, f64)]) -> Result<Vec<PressError>, Error> {
    let depths_m: Vec<f64> = wanted.iter().map(|(depth_m, _)| *depth_m).collect();
    let pressed = settled.press(offset_m, &depths_m)?;
    let error = |((depth_m, wanted_m2), found): (&(f64, f64), Option<Settled>)| PressError {
        place_m: offset_m.into(),
        depth_m: *depth_m,
        limited: found.is_some_and(|found| found.limited),
        pct: found.map(|found| error_pct(found.force_m2, *wanted_m2)),
    };
    Ok(wanted.iter().zip(pressed).map(error).collect())
}

/// Errors by depth. The error at the centre is that of a press that was solved there, if there is
/// one.
fn by_depth(
    depths_m: &[f64],
    fitted_m: &[f64],
    direct: &[PressError],
    disc: &[PressError],
    centred: &[PressError],
) -> Vec<DepthVerdict> {
    let at_depth = |depth_m: &f64| {
        let column: Vec<f64> = disc.iter().filter(|press| press.depth_m == *depth_m).filter_map(|press| press.pct).collect();
        let fitted_depth = fitted_m.contains(depth_m);
        let solved = direct
            .iter()
            .filter(|_| !fitted_depth)
            .find(|press| press.depth_m == *depth_m && Vector::from(press.place_m).norm() < CENTRED_M);
        let centre = solved.or_else(|| centred.iter().find(|press| press.depth_m == *depth_m));
        DepthVerdict {
            depth_mm: depth_m * 1e3,
            fitted_depth,
            centred_pct: centre.and_then(|press| press.pct).unwrap_or(f64::NAN),
            rms_pct: rms(&column),
            worst_pct: worst(&column),
        }
    };
    depths_m.iter().map(at_depth).collect()
}
