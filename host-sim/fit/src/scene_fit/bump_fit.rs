//! Fits the patch of an already fitted block to the bump of its inclusions.
//!
//! The stiffness of the inclusions is first applied to the patch by scaling. Then the springs and
//! nodes in and around them are fitted to a target: the patch's own force without the inclusions
//! plus the bump from finite elements. Errors of the block's fit thus neither enter the bump nor
//! are corrected by it.

use palpate::Params;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::bump::{Bumps, KNOWN_RADII};
use super::fit::{Prepared, aside_of};
use super::piece::tissue_of;
use crate::calibrate::places::sunflower;
use crate::calibrate::targets::{ForceTarget, PlaceTarget, Reference, Targets};
use crate::calibrate::{
    CalibrateError, Calibration, Objective, Positions, Round, Settings, Unknowns, gauss_newton, too_many_lost,
};
use crate::force_map::BlockForces;
use crate::pressed_patch::{NOT_BEGUN, PressedPatch, larger, rms, worst};
use crate::settled::{Settled, SettledPatch};
use crate::statics::{Balance, Statics, Unbalanced, Vector};
use palpate_tissue::answer::{Answer, AnswerProbe, HoldAnswer};
use palpate_tissue::budget::MACHINES;
use palpate_tissue::error::Error;
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::{Inclusion, Scene};
use palpate_tissue::session::Session;
use palpate_tissue::tissue::{Tissue, ratio_of};

/// Deviation of a bump, as a share of the highest bump at its depth, that counts as one unit of
/// error (1).
const TOLERANCE: f64 = 0.01;
/// Factor on the requested number of places at each depth, in the order of increasing depth.
const TIMES: [f64; 3] = [2.0, 1.5, 1.0];
/// Share of the force below which bumps are not felt and need not be fitted more exactly (1).
const LEAST_BUMP: f64 = 1e-3;

/// Bump of a patch over E and that of the finite elements [m^2].
type Pair = Option<(f64, f64)>;

/// Presses at a place, and the positions of the nodes in each of them [m].
type Target = (PlaceTarget, Vec<Vec<Vector>>);

/// Error of the bump at one depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BumpDepth {
    /// Depth [mm].
    pub depth_mm: f64,
    /// Whether this depth was in the fit; the places were not.
    pub fitted_depth: bool,
    /// Highest bump over all places, divided by the force without the inclusions there [%].
    pub highest_pct: f64,
    /// Root mean square error over places, as a share of the highest bump [%].
    pub rms_pct: f64,
    /// Largest error, with its sign, as a share of the highest bump [%].
    pub worst_pct: f64,
}

/// Errors of the bump of a patch at unseen places.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BumpVerdict {
    /// Errors by depth, in ascending order.
    pub depths: Vec<BumpDepth>,
    /// Root mean square error over places and depths, as a share of the highest bump at each depth
    /// [%].
    pub rms_pct: f64,
    /// Largest of these errors, with its sign [%].
    pub worst_pct: f64,
    /// Number of places at which the bump was evaluated.
    pub places: usize,
    /// Number of presses that could not be evaluated because the patch does not come to rest.
    pub lost_presses: usize,
    /// Total number of presses.
    pub presses: usize,
}

/// The homogeneous patch of a block, and the effect of inclusions on that block.
#[derive(Clone, Copy)]
pub struct BumpFit<'a> {
    /// Block without the inclusions.
    pub prepared: &'a Prepared,
    /// Patch that was fitted to that block, and its parameters.
    pub plain: (&'a Patch, &'a Params),
    /// Reference forces without the inclusions.
    pub known: &'a BlockForces,
    /// Ratios of the forces with and without the inclusions.
    pub bumps: &'a Bumps,
    /// Inclusions of the scene.
    pub inclusions: &'a [Inclusion],
}

impl BumpFit<'_> {
    /// Patch to which the stiffness of the inclusions was applied by scaling.
    #[must_use]
    pub fn scaled(&self) -> Patch {
        self.plain.0.clone().with_inclusions(self.inclusions)
    }

    /// Patch with stiffnesses from the formulas alone.
    #[must_use]
    pub fn uncalibrated(&self) -> Patch {
        Patch::build(&self.tissue(), &self.prepared.material, None)
    }

    /// Reference forces with the inclusions, for the evaluation.
    #[must_use]
    pub fn bumped(&self) -> Bumped<'_> {
        Bumped { known: self.known, bumps: self.bumps }
    }

    /// Presses that were solved with the inclusions: at places for the fit, and at others.
    #[must_use]
    pub fn answers(&self, scene: &Scene) -> [Answer; 2] {
        let of = |places: &[[f64; 2]]| {
            let hold = |place: &[f64; 2], depth_m: f64| {
                let plain_m2 = self.known.force(Vector::new(place[0], place[1], 0.0), depth_m)?;
                let force_over_e_m2 = plain_m2 * self.bumps.ratio(*place, depth_m)?;
                Some(HoldAnswer { place_m: [place[0], place[1], 0.0], depth_m, force_over_e_m2, surface: None })
            };
            let depths = &self.bumps.depths_m;
            let holds = places.iter().flat_map(|place| depths.iter().filter_map(move |depth_m| hold(place, *depth_m)));
            let probe = AnswerProbe { shape: scene.probe.shape, radius_m: scene.probe.radius_m };
            Answer { tissue: tissue_of(scene), probe, holds: holds.collect(), glued: Vec::new() }
        };
        [of(&self.bumps.places_m[..self.bumps.known_places]), of(self.bumps.unseen_m())]
    }

    /// Fits the patch to the bump.
    ///
    /// # Errors
    /// Fails if a press at the centre, or more than one in fifty elsewhere, has no equilibrium, or
    /// if the fit brings no improvement.
    pub fn fit(&self, scene: &Scene, settings: &Settings, progress: &mut dyn FnMut(&Round)) -> Result<Calibration, Error> {
        let failed = |cause: CalibrateError| Error::Check(format!("{}: tissue.inclusion: {cause}", scene.file));
        let (patch, params) = self.plain;
        let tissue = self.tissue();
        let material = &self.prepared.material;
        let own = patch.multipliers_over(&Patch::build(&self.prepared.tissue, material, None));
        let base = Patch::build(&tissue, material, Some(&own));
        let statics = Statics::of(&base.model(), params).map_err(|cause| failed(cause.into()))?;
        let unknowns = Unknowns::of(&statics, &tissue, 0.0).only(&statics, &near(&tissue));
        let (targets, starts, lost_targets) = self.targets(settings.places).map_err(|cause| failed(cause.into()))?;
        let objective = Objective::new(statics, unknowns, &targets).map_err(|cause| failed(cause.into()))?;
        let mut objective = objective.starting_near(starts);
        let rounds = gauss_newton::fit(&mut objective, settings, progress).map_err(failed)?;
        let (multipliers, params) = objective.unknowns().result(objective.statics(), objective.place(), params);
        let multipliers = own.times(&multipliers);
        let lost_presses = lost_targets + objective.lost_presses();
        let mut patch = Patch::build(&tissue, material, Some(&multipliers));
        patch.set_fitted_places(settings.places as u32);
        patch.set_scaled();
        Ok(Calibration { params, patch, rounds, lost_presses })
    }

    /// Tissue of the block with its inclusions.
    fn tissue(&self) -> Tissue {
        let tissue = &self.prepared.tissue;
        let ratio = |tet| ratio_of(&tissue.mesh, tet, self.inclusions);
        Tissue { stiffness_ratio: tissue.mesh.tets.iter().map(ratio).collect(), ..tissue.clone() }
    }

    /// Bump over E at a solved place and depth [m^2].
    fn bump_m2(&self, place_m: [f64; 2], depth_m: f64) -> Option<f64> {
        let plain_m2 = self.known.force(Vector::new(place_m[0], place_m[1], 0.0), depth_m)?;
        Some(plain_m2 * (self.bumps.ratio(place_m, depth_m)? - 1.0))
    }

    /// Highest bump over E of all places at a depth [m^2], and the force over E without the
    /// inclusions there [m^2].
    fn highest_m2(&self, depth_m: f64) -> (f64, f64) {
        let of = |place: &[f64; 2]| {
            let bump_m2 = self.bump_m2(*place, depth_m)?;
            Some((bump_m2, bump_m2 / (self.bumps.ratio(*place, depth_m)? - 1.0)))
        };
        self.bumps
            .places_m
            .iter()
            .filter_map(of)
            .fold((0.0, 1.0), |best, own| if own.0.abs() > best.0.abs() { own } else { best })
    }

    /// Returns the targets, presses at many places because a fit to few of them oscillates between
    /// them; the node positions of each press without the inclusions [m]; and the number of presses
    /// that are left out because the patch without inclusions has no equilibrium there.
    fn targets(&self, asked: usize) -> Result<(Targets, Positions, usize), Unbalanced> {
        let (patch, params) = self.plain;
        let pressed = PressedPatch::of(patch, params)?;
        let radius_m = f64::from(params.probe.radius_m);
        let fitted: Vec<(f64, f64)> = self.bumps.fitted_m.iter().copied().zip(TIMES).collect();
        let depths: Vec<f64> = fitted.iter().map(|(depth_m, _)| *depth_m).collect();
        let mut all = vec![([0.0; 2], depths)];
        for (count, depths) in aside_of(asked, &params.probe, &fitted) {
            let depths: Vec<f64> = depths.iter().map(|(depth_m, _)| *depth_m).collect();
            all.extend(sunflower(count, KNOWN_RADII * radius_m).into_iter().map(|place| (place, depths.clone())));
        }
        let place = |(place, depths): &([f64; 2], Vec<f64>)| {
            let offset_m = Vector::new(place[0], place[1], 0.0);
            let target = |depth_m: f64, plain_m2: f64| {
                let known_m2 = self.known.force(offset_m, depth_m)?;
                let force = plain_m2 + known_m2 * (self.bumps.ratio_between(*place, depth_m)? - 1.0);
                let unit_m2 = (TOLERANCE * self.highest_m2(depth_m).0.abs()).max(TOLERANCE * LEAST_BUMP * force);
                Some(ForceTarget { depth_m, force, tolerance: unit_m2 / force })
            };
            let both = |depth_m: f64, here: &Balance| Some((target(depth_m, here.force)?, here.x_m.clone()));
            let (found, unbalanced) = pressed.press_while_balanced(offset_m, depths.iter().copied(), both);
            let (forces, starts) = found.into_iter().collect::<Option<Vec<_>>>().ok_or(NOT_BEGUN)?.into_iter().unzip();
            match unbalanced.filter(|_| *place == [0.0; 2]) {
                Some(at_the_centre) => Err(at_the_centre),
                None => Ok(((PlaceTarget { place_m: pressed.site_m + offset_m, forces, dents: Vec::new() }, starts), unbalanced)),
            }
        };
        let found: Vec<(Target, Option<Unbalanced>)> = all.par_iter().map(place).collect::<Result<_, Unbalanced>>()?;
        let (found, unbalanced): (Vec<_>, Vec<Option<Unbalanced>>) = found.into_iter().unzip();
        let (places, starts): (Vec<PlaceTarget>, Positions) = found.into_iter().unzip();
        let presses: usize = all.iter().map(|(_, depths)| depths.len()).sum();
        let lost = presses - places.iter().map(|p| p.forces.len()).sum::<usize>();
        if let Some(error) = unbalanced.into_iter().flatten().next().filter(|_| too_many_lost(lost, presses)) {
            return Err(error);
        }
        Ok((Targets { places, glued: Vec::new(), centre_m: pressed.site_m, radius_m, disc_radii: KNOWN_RADII }, starts, lost))
    }

    /// Bumps of a patch and of the finite elements over E [m^2] at the places on the line, shape
    /// \[depths\]\[places\]; NaN where the patch does not come to rest.
    ///
    /// # Errors
    /// Fails if a patch cannot run.
    pub fn along_the_line(&self, session: &Session) -> Result<Vec<Vec<(f64, f64)>>, Error> {
        let places = self.pairs(session, self.bumps.line_m())?;
        let depths = 0..self.bumps.depths_m.len();
        let at = |place: &Vec<Pair>, n: usize| place.get(n).copied().flatten().unwrap_or((f64::NAN, f64::NAN));
        Ok(depths.map(|n| places.iter().map(|place| at(place, n)).collect()).collect())
    }

    /// Evaluates the bump of the patch of a session at unseen places.
    ///
    /// # Errors
    /// Fails if a patch cannot run.
    pub fn judge(&self, session: &Session) -> Result<BumpVerdict, Error> {
        let places = self.pairs(session, self.bumps.unseen_m())?;
        let at_depth = |(n, depth_m): (usize, &f64)| {
            let (highest_m2, plain_m2) = self.highest_m2(*depth_m);
            let found = |place: &Vec<Pair>| place.get(n).copied().flatten();
            let error = |(own, wanted): (f64, f64)| 100.0 * (own - wanted) / highest_m2.abs();
            let errors: Vec<f64> = places.iter().filter_map(found).map(error).collect();
            BumpDepth {
                depth_mm: depth_m * 1e3,
                fitted_depth: self.bumps.fitted_m.contains(depth_m),
                highest_pct: 100.0 * highest_m2 / plain_m2,
                rms_pct: rms(&errors),
                worst_pct: worst(&errors),
            }
        };
        let depths: Vec<BumpDepth> = self.bumps.depths_m.iter().enumerate().map(at_depth).collect();
        let all: Vec<f64> = depths.iter().map(|d| d.rms_pct).collect();
        Ok(BumpVerdict {
            rms_pct: rms(&all),
            worst_pct: depths.iter().map(|d| d.worst_pct).fold(0.0, larger),
            places: places.len(),
            lost_presses: places.iter().flatten().filter(|pair| pair.is_none()).count(),
            presses: places.iter().map(Vec::len).sum(),
            depths,
        })
    }

    /// Bumps of a patch and of the finite elements over E [m^2], shape \[places\]\[depths\]; `None`
    /// where the patch does not come to rest with the inclusions or without them.
    fn pairs(&self, session: &Session, places_m: &[[f64; 2]]) -> Result<Vec<Vec<Pair>>, Error> {
        let (patch, params) = self.plain;
        let without = Session::of_fitted(&MACHINES[0], patch.clone(), *params)?;
        let (plain, own) = (SettledPatch::of(&without), SettledPatch::of(session));
        let depths_m = &self.bumps.depths_m;
        let place = |place: &[f64; 2]| {
            let offset_m = Vector::new(place[0], place[1], 0.0);
            let forces = plain.press(offset_m, depths_m)?.into_iter().zip(own.press(offset_m, depths_m)?);
            let pair = |(depth_m, (without, with)): (&f64, (Option<Settled>, Option<Settled>))| {
                Some((with?.force_m2 - without?.force_m2, self.bump_m2(*place, *depth_m)?))
            };
            Ok(depths_m.iter().zip(forces).map(pair).collect())
        };
        places_m.par_iter().map(place).collect()
    }
}

/// Forces of a block with its inclusions: those of the block without them, times the ratio of the
/// bump.
#[derive(Clone, Copy)]
pub struct Bumped<'a> {
    known: &'a BlockForces,
    bumps: &'a Bumps,
}

impl Reference for Bumped<'_> {
    fn force(&self, place_m: Vector, depth_m: f64) -> Option<f64> {
        Some(self.known.force(place_m, depth_m)? * self.bumps.ratio_between([place_m.x, place_m.y], depth_m)?)
    }

    fn deepest_m(&self) -> f64 {
        self.known.deepest_m()
    }

    fn shallowest_m(&self) -> f64 {
        self.known.shallowest_m()
    }

    fn displacement_m(&self, _: f64, _: [f64; 2]) -> Option<[f64; 3]> {
        None
    }
}

/// Whether each node belongs to a tet that contains a part of an inclusion.
fn near(tissue: &Tissue) -> Vec<bool> {
    let mut near = vec![false; tissue.mesh.nodes_m.len()];
    for (tet, ratio) in tissue.mesh.tets.iter().zip(&tissue.stiffness_ratio) {
        if *ratio != 1.0 {
            tet.iter().for_each(|n| near[*n as usize] = true);
        }
    }
    near
}
