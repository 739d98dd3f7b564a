//! Makes a calibrated patch with its far field from a scene: whole organ, cut, rim springs,
//! reference of the whole organ, and fit.

use palpate::Params;
use serde::Serialize;

use super::organ_reference::organ_reference_kept;
use super::surface_map::SurfaceMap;
use super::whole::whole;
use super::{FarField, RimSprings, Sizes};
use crate::calibrate::accuracy::Accuracy;
use crate::calibrate::places::sunflower;
use crate::calibrate::reference_map::ReferenceMap;
use crate::calibrate::targets::{GLUED_TOLERANCE, Reference};
use crate::calibrate::{Calibration, Round, Settings, Targets, calibrate};
use crate::solved::Solved;
use crate::statics::Vector;
use palpate_tissue::answer::{Answer, GluedAnswer};
use palpate_tissue::error::Error;
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::scene::{Drive, Scene};
use palpate_tissue::tissue::Placed;
use palpate_tissue::tissue::Tissue;

/// Radius of the disc of fitted places [probe radii]: slightly more than one, the radius for which
/// accuracy is promised.
const DISC_RADII: f64 = 1.15;
/// Radius of the disc over which a patch is evaluated [probe radii].
pub const JUDGED_RADII: f64 = 1.0;
/// Number of places over that disc; no fit uses them.
pub const JUDGED_PLACES: usize = 60;
/// Smallest and largest allowed radius of a patch [probe radii].
const RADII: [f64; 2] = [1.25, 4.0];
/// Maximum number of nodes within the fine radius.
const MOST_FINE_NODES: f64 = 1000.0;
/// Distance over which places are spread to both sides of a stroke [probe radii].
const HALF_WIDTH_RADII: f64 = 0.5;
/// Factor on the weight of presses at the centre, which is one place of a hundred and the one that
/// is pressed most often.
const CENTRE_WEIGHT: f64 = 3.0;
/// Depths of the presses at the centre [probe radii], which include depths between those at which a
/// patch is evaluated: a fit to five depths met these and varied by 2-4 % between them.
const CENTRE_DEPTHS_RADII: [f64; 12] = [0.0625, 0.0885, 0.125, 0.156, 0.21875, 0.25, 0.3125, 0.4375, 0.5, 0.625, 0.8125, 1.0];
/// Range of the depths of presses around the site [probe radii] that are given a larger weight, and
/// the factor on it: such presses rest on a few foundation points and have the largest errors at
/// places that are not in the fit. Shallower presses are not included.
const SHALLOW_RADII: [f64; 2] = [0.1, 0.2];
const SHALLOW_WEIGHT: f64 = 2.0;
/// Radius of the ring on which glued discs are fitted, besides those at the site [probe radii], and
/// their number.
const RING_RADII: f64 = 0.5;
const RING: usize = 4;
/// Number of places besides the site at which the finite elements of an organ are pressed, and the
/// radius around the site over which they are spread [probe radii].
const SOLVED_PLACES: usize = 10;
const SOLVED_RADII: f64 = 1.2;
/// Depths at which an organ is pressed, as shares of the deepest hold (1).
const SOLVED_DEPTHS: [f64; 4] = [0.125, 0.25, 0.5, 1.0];

/// Reference for fitting and evaluating the patch of a scene.
pub enum Truth {
    /// Stored answer for the default block.
    Block(Answer),
    /// Finite-element answers for this organ.
    Organ(Box<SurfaceMap>),
}

impl Truth {
    /// Returns the stored answer if it belongs to this scene, pressed at its centre. Otherwise
    /// finite elements solve the whole organ, which takes a minute or two.
    ///
    /// # Errors
    /// See [`organ_reference_kept`].
    pub fn of(scene: &Scene, placed: &Placed, progress: impl Fn(usize, usize) + Sync) -> Result<Self, Error> {
        Self::kept(scene, placed, None, progress)
    }

    /// Like [`Self::of`], but reuses finite-element answers in `solved`.
    ///
    /// # Errors
    /// See [`organ_reference_kept`].
    pub fn kept(
        scene: &Scene,
        placed: &Placed,
        solved: Option<&Solved>,
        progress: impl Fn(usize, usize) + Sync,
    ) -> Result<Self, Error> {
        let answer = Answer::block();
        let centred = scene.probe.position_m.unwrap_or_default() == [0.0; 2];
        let deep_enough = |map: ReferenceMap| map.deepest_m() * (1.0 + 1e-9) >= deepest_hold_m(scene).unwrap_or_default();
        if centred && answer.is_for(scene) && ReferenceMap::of(&answer).is_some_and(deep_enough) {
            return Ok(Self::Block(answer));
        }
        let radius_m = scene.probe.radius_m;
        let deepest_m = deepest_hold_m(scene).unwrap_or(placed.tissue.depth_limit_m);
        let depths_m = SOLVED_DEPTHS.map(|share| share * deepest_m);
        let mut offsets_m = vec![[0.0; 2]];
        offsets_m.extend(sunflower(SOLVED_PLACES, SOLVED_RADII * radius_m));
        let reference = organ_reference_kept(scene, placed, &offsets_m, &depths_m, solved, progress)?;
        let map = SurfaceMap::of(&reference, placed, &scene.probe);
        map.map(|map| Self::Organ(Box::new(map)))
            .ok_or_else(|| Error::Check("the finite elements gave no smooth surface of forces".into()))
    }

    /// Calls `question` with this truth as a reference.
    pub fn ask<R>(&self, question: impl FnOnce(&dyn Reference) -> R) -> R {
        match self {
            Self::Block(answer) => match ReferenceMap::of(answer) {
                Some(map) => question(&map),
                None => question(&Nothing),
            },
            Self::Organ(map) => question(map.as_ref()),
        }
    }
}

impl Truth {
    /// Calls `question` with this truth as a reference on another mesh of the same organ.
    pub fn ask_on<R>(&self, placed: &Placed, question: impl FnOnce(&dyn Reference) -> R) -> R {
        match self {
            Self::Block(_) => self.ask(question),
            Self::Organ(map) => question(&map.on(placed)),
        }
    }
}

/// A reference without any answer.
struct Nothing;

impl Reference for Nothing {
    fn force(&self, _: Vector, _: f64) -> Option<f64> {
        None
    }

    fn deepest_m(&self) -> f64 {
        0.0
    }

    fn displacement_m(&self, _: f64, _: [f64; 2]) -> Option<[f64; 3]> {
        None
    }
}

/// Depth of the deepest hold of a scene whose drive has given depths [m].
pub(crate) fn deepest_hold_m(scene: &Scene) -> Option<f64> {
    match &scene.drive {
        Drive::Depth { holds_m, .. } | Drive::Hand { holds_m, .. } => holds_m.iter().copied().reduce(f64::max),
        _ => None,
    }
}

/// Choices for making a patch from a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    /// Sizes of the patch and of its elements.
    pub sizes: Sizes,
    /// Number of foundation points per triangle: 4, 9 or, except for boards, 16.
    pub points_per_triangle: usize,
    /// Settings of the fit, such as the number of places and of rounds.
    pub settings: Settings,
}

impl Recipe {
    /// A patch of `radius_m` with elements of `fine_m` under a probe of `probe_radius_m`.
    #[must_use]
    pub fn new(radius_m: f64, fine_m: f64, probe_radius_m: f64) -> Self {
        Self {
            sizes: Sizes { radius_m, fine_m, fine_radius_m: probe_radius_m, growth: 0.45, stroke_m: [0.0; 3] },
            points_per_triangle: if fine_m > 0.4 * probe_radius_m { 9 } else { 4 },
            settings: Settings { places: 100, ..Settings::default() },
        }
    }
}

/// The whole organ of a scene and the far field around a patch of it: all that is needed before the
/// fit.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Mesh of the whole organ, with site and axis.
    pub placed: Placed,
    /// Far field of the patch: the cut and the rim springs.
    pub far: FarField,
    /// Constants of the material.
    pub material: Material,
    /// Parameters of the scene.
    pub params: Params,
    /// Stroke of the probe, centred on the site [m]; zero for presses at the site.
    pub stroke_m: [f64; 3],
}

impl Prepared {
    /// Meshes the organ, cuts the patch out and condenses the outside.
    ///
    /// # Errors
    /// Fails if scene, sizes or organ do not permit it.
    pub fn of(scene: &Scene, recipe: &Recipe) -> Result<Self, Error> {
        if scene.tissue.gravity_m_per_s2 != [0.0; 3] {
            return Ok(scene.bad(
                "tissue.gravity_m_per_s2",
                "is not zero: a far field carries no weight, take the shape under gravity as the rest shape",
            )?);
        }
        refuse_odd(scene, &recipe.sizes)?;
        refuse_too_fine(scene, &recipe.sizes)?;
        let placed = whole(scene, &[], &recipe.sizes)?;
        let params = scene.params(placed.axis);
        let material = Material {
            poisson_ratio: scene.tissue.poisson_ratio,
            points_per_triangle: recipe.points_per_triangle,
            ..Material::default()
        };
        let far = FarField::of(&placed.tissue, &recipe.sizes, &material, &params)
            .map_err(|cause| Error::Usage(format!("{}: {cause}", scene.file)))?;
        Ok(Self { placed, far, material, params, stroke_m: recipe.sizes.stroke_m })
    }

    /// The uncalibrated patch with its rim springs.
    #[must_use]
    pub fn patch(&self) -> Patch {
        self.far.patch(&self.material)
    }

    /// Fits the patch to a truth.
    ///
    /// # Errors
    /// Fails if the reference lacks presses or if the patch cannot be pressed.
    pub fn fit(&self, truth: &Truth, settings: &Settings, progress: &mut dyn FnMut(&Round)) -> Result<Fitted, Error> {
        let stroke: f64 = self.stroke_m.iter().map(|s| s * s).sum();
        if stroke > 0.0 && matches!(truth, Truth::Organ(_)) {
            let why =
                "a patch for a stroke is calibrated on the default block only: leave --stroke out, or take a larger --radius";
            return Err(Error::Usage(why.into()));
        }
        truth.ask(|reference| self.fit_to(reference, settings, progress))
    }

    fn fit_to(&self, reference: &dyn Reference, settings: &Settings, progress: &mut dyn FnMut(&Round)) -> Result<Fitted, Error> {
        let fit = if self.stroke_m == [0.0; 3] {
            let tissue = &self.far.cut.patch;
            fit_tissue(tissue, Some(&self.far.springs), &self.material, &self.params, reference, settings, progress)?
        } else {
            self.fit_along_the_stroke(reference, settings, progress)?
        };
        let failed = |cause: &dyn std::fmt::Display| Error::Check(format!("the patch cannot be fitted: {cause}"));
        let accuracy =
            Accuracy::of(&fit.patch, &fit.params, reference, JUDGED_RADII, JUDGED_PLACES).map_err(|cause| failed(&cause))?;
        Ok(Fitted { patch: fit.patch, params: fit.params, rounds: fit.rounds, accuracy })
    }
}

impl Prepared {
    fn fit_along_the_stroke(
        &self,
        reference: &dyn Reference,
        settings: &Settings,
        progress: &mut dyn FnMut(&Round),
    ) -> Result<Calibration, Error> {
        let tissue = &self.far.cut.patch;
        let (site_m, probe_m) = (Vector::from(tissue.site_m), f64::from(self.params.probe.radius_m));
        let half_width_m = HALF_WIDTH_RADII * probe_m;
        let lacking = || Error::Check("the reference does not know the whole stroke: make it shorter".into());
        let targets = Targets::over_a_stroke(reference, site_m, self.stroke_m, half_width_m, probe_m, settings.places)
            .ok_or_else(lacking)?;
        let targets = targets.with_glued(&glued_around(reference.glued(), probe_m), GLUED_TOLERANCE);
        calibrate(tissue, &self.material, Some(&self.far.springs), &self.params, &targets, settings, progress)
            .map_err(|cause| unfitted(&cause))
    }
}

fn unfitted(cause: &crate::calibrate::CalibrateError) -> Error {
    Error::Check(format!("the patch cannot be fitted: {cause}"))
}

/// Refuses a radius outside its range. A patch that is narrower than the spread of the contact is
/// wrong, however it is fitted; a much wider one costs as much as a whole organ.
fn refuse_odd(scene: &Scene, sizes: &Sizes) -> Result<(), Error> {
    let probe_m = scene.probe.radius_m;
    let [least_m, most_m] = RADII.map(|radii| radii * probe_m);
    // a small tolerance for rounding in products of decimal numbers
    if !((1.0 - 1e-9) * least_m..=(1.0 + 1e-9) * most_m).contains(&sizes.radius_m) {
        return Err(Error::Usage(format!(
            "{}: a patch of {} m around a probe of {probe_m} m: give a radius of {least_m:.4} to {most_m:.4} m",
            scene.file, sizes.radius_m
        )));
    }
    if !(sizes.fine_m.is_finite() && sizes.fine_m > 0.0) {
        return Err(Error::Usage(format!("{}: elements of {} m: give a length above zero", scene.file, sizes.fine_m)));
    }
    Ok(())
}

/// Refuses elements so small that meshing would take minutes; such a mesh is also too large for any
/// board.
fn refuse_too_fine(scene: &Scene, sizes: &Sizes) -> Result<(), Error> {
    // estimate for regular tets in half a ball, with sqrt(2) nodes per cube of the edge length
    let half_ball_m3 = 2.0 / 3.0 * std::f64::consts::PI * sizes.fine_radius_m.min(sizes.radius_m).powi(3);
    let nodes = half_ball_m3 * std::f64::consts::SQRT_2 / sizes.fine_m.powi(3);
    if nodes <= MOST_FINE_NODES {
        return Ok(());
    }
    let least_m = sizes.fine_m * (nodes / MOST_FINE_NODES).cbrt();
    Err(Error::Usage(format!(
        "{}: elements of {} m put about {nodes:.0} nodes under the probe alone: give at least {least_m:.5} m",
        scene.file, sizes.fine_m
    )))
}

/// Fits the patch of a tissue, with its rim springs if it has some, to a reference over a disc
/// slightly larger than that of the evaluation.
///
/// # Errors
/// Fails if the reference lacks presses or if the patch cannot be pressed.
pub fn fit_tissue(
    tissue: &Tissue,
    rim: Option<&RimSprings>,
    material: &Material,
    params: &Params,
    reference: &dyn Reference,
    settings: &Settings,
    progress: &mut dyn FnMut(&Round),
) -> Result<Calibration, Error> {
    let site_m = Vector::from(tissue.site_m);
    let radius_m = f64::from(params.probe.radius_m);
    let knows_dents = reference.displacement_m(0.25 * radius_m, [0.0; 2]).is_some();
    let surface = if knows_dents { skin_nodes(tissue) } else { Vec::new() };
    let lacks = || Error::Check("the reference lacks presses that the fit needs: press deeper or take a larger organ".into());
    let mut targets =
        Targets::over_a_disc(reference, &surface, site_m, radius_m, DISC_RADII, settings.places).ok_or_else(lacks)?;
    let shallow = SHALLOW_RADII[0] * radius_m..SHALLOW_RADII[1] * radius_m;
    let around = targets.places.iter_mut().flat_map(|place| &mut place.forces);
    around.filter(|f| shallow.contains(&f.depth_m)).for_each(|f| f.tolerance /= SHALLOW_WEIGHT);
    let centred = targets.with_centre(reference, &CENTRE_DEPTHS_RADII, CENTRE_WEIGHT);
    let targets = centred.ok_or_else(lacks)?.with_glued(&glued_around(reference.glued(), radius_m), GLUED_TOLERANCE);
    calibrate(tissue, material, rim, params, &targets, settings, progress).map_err(|cause| unfitted(&cause))
}

/// Returns the solved discs at the site, and interpolated discs on a ring around it. The
/// interpolation takes the change of stiffness from the site to be proportional to the square of
/// the distance from it.
fn glued_around(solved: &[GluedAnswer], probe_m: f64) -> Vec<GluedAnswer> {
    let away = |disc: &GluedAnswer| disc.place_m[0].hypot(disc.place_m[1]);
    let mut discs = Vec::new();
    for centred in solved.iter().filter(|disc| away(disc) == 0.0) {
        discs.push(*centred);
        let aside = solved.iter().find(|d| away(d) > 0.0 && d.direction == centred.direction && d.radius_m == centred.radius_m);
        let Some(aside) = aside else { continue };
        let share = (RING_RADII * probe_m / away(aside)).powi(2).min(1.0);
        let stiffness_over_e_m = centred.stiffness_over_e_m + share * (aside.stiffness_over_e_m - centred.stiffness_over_e_m);
        for n in 0..RING {
            let (sin, cos) = (std::f64::consts::TAU * (n as f64 + 0.25) / RING as f64).sin_cos();
            let place_m = [RING_RADII * probe_m * cos, RING_RADII * probe_m * sin, 0.0];
            discs.push(GluedAnswer { place_m, stiffness_over_e_m, ..*centred });
        }
    }
    discs
}

fn skin_nodes(tissue: &Tissue) -> Vec<(usize, Vector)> {
    let mut nodes: Vec<u32> = tissue.skin.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.into_iter().map(|n| (n as usize, Vector::from(tissue.mesh.nodes_m[n as usize]))).collect()
}

/// A calibrated patch with its far field.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// Patch with the fitted multipliers and its rim springs.
    pub patch: Patch,
    /// Parameters with the fitted scalars.
    pub params: Params,
    /// Records of the rounds of the fit.
    pub rounds: Vec<Round>,
    /// Accuracy of the patch, at places and depths of which most are not in the fit.
    pub accuracy: Accuracy,
}

/// Summary of the force errors [%].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Short {
    /// Root mean square of the centred presses [%].
    pub centred_rms_pct: f64,
    /// Root mean square over unseen places of the disc and the chosen depths [%].
    pub disc_rms_pct: f64,
    /// Largest error over these places and depths, with its sign [%].
    pub disc_worst_pct: f64,
}

impl Fitted {
    /// Summarises the errors: all centred presses, and the presses over the disc with depths from
    /// `from_m` to `to_m`.
    #[must_use]
    pub fn short(&self, from_m: f64, to_m: f64) -> Short {
        let inside = |mm: f64| (from_m..=to_m).contains(&(mm * 1e-3));
        let depths: Vec<f64> = self.accuracy.forces.iter().map(|f| f.depth_mm).collect();
        let disc: Vec<f64> = depths.iter().copied().filter(|mm| inside(*mm)).collect();
        let (disc_rms_pct, disc_worst_pct) = self.accuracy.disc_pct(&disc);
        Short { centred_rms_pct: self.accuracy.centred_rms_pct(&depths), disc_rms_pct, disc_worst_pct }
    }
}
