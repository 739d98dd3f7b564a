//! A patch that is cut out of a block, an organ or a mesh: its element size, and the presses of the
//! whole for its fit and its evaluation.

use super::fit::{CENTRE_TOLERANCE, aside_of};
use super::presses::{Level, UNSEEN_PLACES, UNSEEN_SEED};
use crate::calibrate::places::{random, sunflower};
use crate::calibrate::targets::{DiscPresses, Reference};
use crate::calibrate::{Calibration, Round, Settings, Targets, calibrate};
use crate::far_field::organ_reference::{OrganReference, PlaceForces, organ_reference};
use crate::far_field::prepared::{Prepared, Recipe, deepest_hold_m, refuse_odd};
use crate::far_field::whole::{shape_of, whole, whole_of};
use crate::far_field::{Cut, RimSprings};
use crate::force_map::{BlockForces, ForceMap, SurfaceForces};
use crate::solved::Solved;
use crate::statics::Vector;
use palpate::Params;
use palpate_tissue::answer::{Answer, AnswerProbe, AnswerTissue, GluedAnswer, HoldAnswer};
use palpate_tissue::error::Error;
use palpate_tissue::fit_record::OrganRecord;
use palpate_tissue::patch::Material;
use palpate_tissue::scene::Scene;
use palpate_tissue::tissue::{Placed, Tissue};

/// Radius of a patch if none is given [probe radii]: at 2 to 2.5, rim springs are within 0.5 % of
/// the exact outside.
pub const PIECE_RADII: f64 = 2.125;
/// Radius of the disc over which such a patch is evaluated [probe radii].
pub const PIECE_JUDGED_RADII: f64 = 1.0;
/// Smallest and largest element size that is tried [probe radii], and number of halvings between
/// them.
const ELEMENTS_RADII: [f64; 2] = [0.25, 1.0];
const HALVINGS: usize = 7;
/// Largest accepted relative deviation from the requested number of nodes (1), since element sizes
/// do not give every number.
const MISSED: f64 = 0.25;
/// Number of fitted places besides the site, the same number with `--quick`, and the radius around
/// the site over which they are spread [probe radii].
const KNOWN_PLACES: usize = 12;
const QUICK_PLACES: usize = 8;
const KNOWN_RADII: f64 = 1.2;
/// Depths of the fit and of the evaluation, as shares of the deepest hold (1).
const FITTED: [f64; 4] = [SHALLOWEST, 0.25, 0.5, 1.0];
const UNSEEN: [f64; 2] = [0.375, 0.75];
const SHALLOWEST: f64 = 0.125;
/// Shallowest depth for which a patch for a board is fitted and evaluated [probe radii]: its few
/// elements are larger than a shallower contact.
const BOARD_RADII: f64 = 0.125;

/// Depths of the fit at the site, as shares of the deepest hold (1). With the solved depths alone,
/// a fit oscillates by 2-4 % between them.
const CENTRE: [f64; 8] = [0.125, 0.177, 0.25, 0.354, 0.5, 0.625, 0.8, 1.0];
/// Depths of the fit around the site, as shares of the deepest hold, each with its own places, and
/// the factor on the requested number of places (1).
const ASIDE: [(f64, f64); 5] = [(0.125, 3.0), (0.25, 2.5), (0.5, 1.75), (0.75, 1.25), (1.0, 1.0)];
/// Radius around the site over which the places of the fit are spread [probe radii].
const FITTED_RADII: f64 = 1.15;
/// Relative deviation of a glued disc's force that counts as one unit of error (1), since there are
/// only a few discs.
const GLUED_TOLERANCE: f64 = 0.002;
/// Shallowest dent that is fitted [probe radii], deviation of a surface node, as a share of the
/// depth, that counts as one unit of error (1), and difference below which two depths count as
/// equal [m].
const DENT_RADII: f64 = 0.2;
const DENT_TOLERANCE: f64 = 0.008;
const SAME_M: f64 = 1e-6;
/// Radius of the ring on which glued discs are fitted, besides those at the site [probe radii], and
/// their number.
const RING_RADII: f64 = 0.5;
const RING: usize = 4;
/// Relative error of the stored answer for the default block (1).
const STORED_ERROR: f64 = 0.003;

/// Forces of the whole at places and depths for the fit and for the evaluation.
#[derive(Clone, Debug)]
pub struct PiecePresses {
    /// Map that interpolates between the places and depths for the fit.
    pub known: ForceMap,
    /// Depths of the fit in ascending order [m].
    pub fitted_m: Vec<f64>,
    /// All solved presses; their places are relative to the site.
    pub answer: Answer,
    /// Presses for the evaluation alone.
    pub unseen: Answer,
    /// Estimated relative error of the force (1): the largest over all depths at the site, and at
    /// least what a smooth map leaves of the forces at the places around it.
    pub error: f64,
    /// Number of nodes of the finest quadratic mesh; `None` for the stored answer.
    pub nodes: Option<usize>,
    /// Depths of the fit in relation to their shares of the deepest hold.
    scale: DepthScale,
}

/// Depths as shares of the deepest hold: the depth is `deepest_m * share^power`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct DepthScale {
    deepest_m: f64,
    power: f64,
}

impl DepthScale {
    fn of(deepest_m: f64, on_board: bool, radius_m: f64) -> Self {
        let shallowest = if on_board { (BOARD_RADII * radius_m / deepest_m).max(SHALLOWEST) } else { SHALLOWEST };
        // a press that is hardly deeper than the shallowest is fitted like any other
        let power = if shallowest < FITTED[2] { shallowest.ln() / SHALLOWEST.ln() } else { 1.0 };
        Self { deepest_m, power }
    }

    fn depth_m(self, share: f64) -> f64 {
        if self.power == 1.0 { share * self.deepest_m } else { share.powf(self.power) * self.deepest_m }
    }
}

/// Edge length of the elements under the probe with which a patch of `radius_m` has about `nodes`
/// nodes [m].
///
/// # Errors
/// Fails if no edge length gives such a number, or if the organ cannot be cut at this radius.
pub fn element_for(scene: &Scene, radius_m: f64, nodes: usize) -> Result<f64, Error> {
    let sizes_of = |edge_m: f64| Recipe::new(radius_m, edge_m, scene.probe.radius_m).sizes;
    refuse_odd(scene, &sizes_of(scene.probe.radius_m))?;
    // a large file is read once
    let shape = if scene.tissue.block_m.is_some() { None } else { Some(shape_of(scene)?) };
    let count = |edge_m: f64| -> Result<usize, Error> {
        let sizes = sizes_of(edge_m);
        let placed = match &shape {
            Some(shape) => whole_of(scene, &[], &sizes, shape)?,
            None => whole(scene, &[], &sizes)?,
        };
        let cut = Cut::of(&placed.tissue, &sizes).map_err(|cause| Error::Usage(format!("{}: {cause}", scene.file)))?;
        Ok(cut.patch.mesh.nodes_m.len())
    };
    let [mut small_m, mut large_m] = ELEMENTS_RADII.map(|radii| radii * scene.probe.radius_m);
    let mut best = (count(large_m)?, large_m);
    let mut off = best.0.abs_diff(nodes);
    for _ in 0..HALVINGS {
        let middle_m = (small_m * large_m).sqrt();
        // elements that cannot be meshed because they are too small count as having too many nodes
        let found = count(middle_m).unwrap_or(usize::MAX);
        if found.abs_diff(nodes) < off {
            (best, off) = ((found, middle_m), found.abs_diff(nodes));
        }
        if found > nodes { small_m = middle_m } else { large_m = middle_m }
    }
    if off as f64 > MISSED * nodes as f64 {
        return Err(Error::Usage(format!(
            "--nodes {nodes}: a patch of {:.1} mm here has {} at the nearest: give that, or another --radius",
            radius_m * 1e3,
            best.0
        )));
    }
    Ok(best.1)
}

impl PiecePresses {
    /// Takes the stored answer if it belongs to the scene, pressed at its centre. Otherwise presses
    /// the whole by finite elements, except for presses that an earlier run has solved, and calls
    /// `progress` with the number of finished presses and the total number. For a patch `on_board`,
    /// no press is shallower than an eighth of the probe's radius.
    ///
    /// # Errors
    /// Fails if a place is beside the surface, if there is no equilibrium at some depth, or if
    /// there is not enough memory.
    pub fn of(
        scene: &Scene,
        placed: &Placed,
        (level, on_board): (Level, bool),
        solved: &Solved,
        progress: impl Fn(usize, usize) + Sync,
    ) -> Result<Self, Error> {
        let deepest_m = deepest_hold_m(scene).unwrap_or(placed.tissue.depth_limit_m);
        let scale = DepthScale::of(deepest_m, on_board, scene.probe.radius_m);
        match Self::stored(scene, scale) {
            Some(stored) => Ok(stored),
            None => Self::solved(scene, placed, level, scale, solved, progress),
        }
    }

    fn stored(scene: &Scene, scale: DepthScale) -> Option<Self> {
        let centred = scene.probe.position_m.unwrap_or_default() == [0.0; 2];
        let answer = Answer::block();
        if !centred || !answer.is_for(scene) {
            return None;
        }
        let known = BlockForces::of(&answer)?;
        if known.deepest_m() * (1.0 + 1e-9) < scale.deepest_m {
            return None;
        }
        let fitted_m = FITTED.map(|share| scale.depth_m(share)).to_vec();
        let between = fitted_m[0]..scale.deepest_m;
        let is_unseen =
            |hold: &&HoldAnswer| hold.place_m == [0.0; 3] && between.contains(&hold.depth_m) && !fitted_m.contains(&hold.depth_m);
        let mut unseen = Answer { holds: answer.holds.iter().filter(is_unseen).cloned().collect(), ..answer.clone() };
        unseen.holds.iter_mut().for_each(|hold| hold.surface = None);
        let known = ForceMap::Block(known);
        Some(Self { known, fitted_m, unseen, answer, error: STORED_ERROR, nodes: None, scale })
    }

    fn solved(
        scene: &Scene,
        placed: &Placed,
        level: Level,
        scale: DepthScale,
        solved: &Solved,
        progress: impl Fn(usize, usize) + Sync,
    ) -> Result<Self, Error> {
        let radius_m = scene.probe.radius_m;
        let places_aside = if level == Level::Quick { QUICK_PLACES } else { KNOWN_PLACES };
        let mut offsets_m = vec![[0.0; 2]];
        offsets_m.extend(sunflower(places_aside, KNOWN_RADII * radius_m));
        offsets_m.extend(random(UNSEEN_PLACES, PIECE_JUDGED_RADII * radius_m, UNSEEN_SEED));
        let fitted_m = FITTED.map(|share| scale.depth_m(share)).to_vec();
        let mut depths_m = fitted_m.clone();
        depths_m.extend(UNSEEN.map(|share| scale.depth_m(share)));
        depths_m.sort_by(f64::total_cmp);
        let all = organ_reference(scene, placed, &offsets_m, &depths_m, Some(solved), progress)?;
        let map = SurfaceForces::of(&known_of(&all, &fitted_m, places_aside), placed.tissue.site_m, &scene.probe);
        let known = map.ok_or_else(|| Error::Check("the finite elements gave no smooth surface of forces".into()))?;
        let scatter = known.misfit;
        let holds = |n: usize, place: &PlaceForces| -> Vec<(usize, HoldAnswer)> {
            let place_m = std::array::from_fn(|k| place.place_m[k] - placed.tissue.site_m[k]);
            let at = all.depths_m.iter().zip(&place.force_over_e_m2);
            let hold = |(depth_m, force): (&f64, &f64)| HoldAnswer {
                place_m,
                depth_m: *depth_m,
                force_over_e_m2: *force,
                surface: None,
            };
            at.map(|at| (n, hold(at))).collect()
        };
        let holds: Vec<(usize, HoldAnswer)> = all.places.iter().enumerate().flat_map(|(n, place)| holds(n, place)).collect();
        let is_unseen = |(n, hold): &&(usize, HoldAnswer)| *n > places_aside || (*n == 0 && !fitted_m.contains(&hold.depth_m));
        let unseen = holds.iter().filter(is_unseen).map(|(_, hold)| hold.clone()).collect();
        let answer = Answer {
            tissue: tissue_of(scene),
            probe: AnswerProbe { shape: scene.probe.shape, radius_m },
            holds: holds.iter().map(|(_, hold)| hold.clone()).collect(),
            glued: Vec::new(),
        };
        Ok(Self {
            known: ForceMap::Surface(Box::new(known)),
            fitted_m,
            unseen: Answer { holds: unseen, ..answer.clone() },
            answer,
            error: all.error.iter().copied().fold(scatter, f64::max),
            nodes: Some(all.nodes),
            scale,
        })
    }

    /// Fits a patch, with its rim springs if it has some, to the answers for the fit.
    ///
    /// # Errors
    /// Fails if the patch cannot be pressed.
    pub fn fit(
        &self,
        (tissue, rim): (&Tissue, Option<&RimSprings>),
        material: &Material,
        params: &Params,
        settings: &Settings,
        progress: &mut dyn FnMut(&Round),
    ) -> Result<Calibration, Error> {
        let radius_m = f64::from(params.probe.radius_m);
        let aside = ASIDE.map(|(share, times)| (self.scale.depth_m(share), times));
        let dents_m = self.dents_m(radius_m);
        let mut centre: Vec<f64> = CENTRE.iter().map(|share| self.scale.depth_m(*share)).collect();
        centre.retain(|depth_m| dents_m.iter().all(|dent_m| (dent_m - depth_m).abs() > SAME_M));
        centre.extend(&dents_m);
        centre.sort_by(f64::total_cmp);
        let surface = if dents_m.is_empty() { Vec::new() } else { skin_nodes(tissue) };
        let disc = DiscPresses {
            centre: centre.into_iter().map(|depth_m| (depth_m, CENTRE_TOLERANCE)).collect(),
            aside: aside_of(settings.places, &params.probe, &aside),
            dents: dents_m.into_iter().map(|depth_m| (depth_m, DENT_TOLERANCE)).collect(),
        };
        let known = self.known.reference();
        let targets = Targets::over(known, &surface, tissue.site_m.into(), radius_m, FITTED_RADII, &disc)
            .ok_or_else(|| Error::Check("the surface ends near the site: take another site, or a smaller probe".into()))?
            .with_glued(&glued_around(known.glued(), radius_m), GLUED_TOLERANCE);
        calibrate(tissue, material, rim, params, &targets, settings, progress)
            .map_err(|cause| Error::Check(format!("the patch cannot be fitted: {cause}")))
    }

    /// Depths of the fit at which the answer has the surface [m]; none for an organ.
    fn dents_m(&self, radius_m: f64) -> Vec<f64> {
        let fitted = self.fitted_m[0].max(DENT_RADII * radius_m)..=self.scale.deepest_m;
        let centred = self.answer.holds.iter().filter(|hold| hold.place_m == [0.0; 3] && hold.surface.is_some());
        centred.map(|hold| hold.depth_m).filter(|depth_m| fitted.contains(depth_m)).collect()
    }

    /// Fits the patch that was cut out of the tissue.
    ///
    /// # Errors
    /// Fails if the patch cannot be pressed.
    pub fn fit_piece(
        &self,
        prepared: &Prepared,
        settings: &Settings,
        progress: &mut dyn FnMut(&Round),
    ) -> Result<Calibration, Error> {
        let far = &prepared.far;
        self.fit((&far.cut.patch, Some(&far.springs)), &prepared.material, &prepared.params, settings, progress)
    }
}

/// Nodes of the surface, with their positions [m].
fn skin_nodes(tissue: &Tissue) -> Vec<(usize, Vector)> {
    let mut nodes: Vec<u32> = tissue.skin.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.into_iter().map(|n| (n as usize, Vector::from(tissue.mesh.nodes_m[n as usize]))).collect()
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

/// Tissue of a scene in the form in which answers and records contain it.
#[must_use]
pub fn tissue_of(scene: &Scene) -> AnswerTissue {
    let tissue = &scene.tissue;
    AnswerTissue {
        block_m: tissue.block_m,
        mesh: OrganRecord::of(scene).map(|organ| organ.name),
        poisson_ratio: tissue.poisson_ratio,
        stiffening_b: tissue.stiffening_b,
        inclusion: tissue.inclusion.clone(),
    }
}

/// The part of a reference that is used for the fit.
fn known_of(all: &OrganReference, fitted_m: &[f64], places: usize) -> OrganReference {
    let at: Vec<usize> = (0..all.depths_m.len()).filter(|n| fitted_m.contains(&all.depths_m[*n])).collect();
    let of = |numbers: &[f64]| at.iter().map(|n| numbers[*n]).collect();
    let place = |place: &PlaceForces| PlaceForces { force_over_e_m2: of(&place.force_over_e_m2), ..place.clone() };
    OrganReference {
        places: all.places.iter().take(1 + places).map(place).collect(),
        depths_m: of(&all.depths_m),
        error: of(&all.error),
        nodes: all.nodes,
        surface: all.surface.clone(),
    }
}
