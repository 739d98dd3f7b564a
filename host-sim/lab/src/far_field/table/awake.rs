//! Regions whose outside is frozen: the share of an organ that must be awake for an accurate force,
//! and the regions that the papers' stress rule selects.
//!
//! The nodes nearest to the contact are awake, all others are frozen at their rest positions. For
//! comparison there are patches with rim springs at the same place and of about the same size, and
//! the regions of (7)-(8) of paper 004 for several thresholds, which are shares of the contact
//! pressure. Errors are relative to the whole mesh with every node awake. Rim springs come in two
//! kinds. Those fitted to the condensed *springs* of the outside show the error of the rim alone.
//! Those fitted to its condensed elements, as the product's are, also show by how much coarse
//! springs far from the contact are stiffer than elements.

use crate::paper_method::region::{ContactPressure, StressRule};
use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use rayon::prelude::*;

use super::presses::solver;
use super::{Scope, Setting, graded};
use crate::error::Error;
use palpate_fit::far_field::springs::rim_answers;
use palpate_fit::far_field::{FarField, Sizes, springs};
use palpate_fit::statics::{Statics, Vector};
use palpate_tissue::Error as TissueError;
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::Scene;
use palpate_tissue::tissue::Tissue;

/// Shares of the free nodes that are awake (1).
const SHARES: [f64; 17] = [0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95];
/// Shares of the nodes that lie in the patches with rim springs (1).
const PATCH_SHARES: [f64; 5] = [0.2, 0.3, 0.4, 0.5, 0.6];
/// Distances of the presses from the site along x [probe radii].
const PLACES_RADII: [f64; 3] = [0.0, 1.5, 2.5];
/// Depths of the presses [probe radii].
const DEPTHS_RADII: [f64; 2] = [0.25, 0.5];
/// Errors for which the smallest share is searched [%].
pub const TOLERANCES_PCT: [f64; 3] = [5.0, 2.0, 1.0];
/// Smallest stresses down to which the rule keeps nodes awake, as shares of the contact pressure
/// (1).
const THRESHOLDS: [f64; 7] = [0.5, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01];
/// Stiffness over E of the springs that hold the rim of the outside while it is condensed [probe
/// radii].
const HELD_RADII: f64 = 1.0;
/// Radius around the site within which the loads of the rim fit act [probe radii].
const LOADS_RADII: f64 = 1.5;

/// Boundary condition around a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surroundings {
    /// All other nodes are frozen.
    Frozen,
    /// Rim springs fitted to the condensed springs of the outside.
    SpringsOfSprings,
    /// Rim springs fitted to the condensed elements of the outside.
    SpringsOfElements,
}

impl Surroundings {
    /// Name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Frozen => "frozen",
            Self::SpringsOfSprings => "rim-springs",
            Self::SpringsOfElements => "rim-springs-from-elements",
        }
    }
}

/// A frozen region or a patch with rim springs, and its force errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frozen {
    /// Number of nodes of the whole mesh.
    pub whole_nodes: usize,
    /// Distance of the press from the site [m].
    pub aside_m: f64,
    /// Boundary condition around the region.
    pub held: Surroundings,
    /// Radius of the region [m].
    pub radius_m: f64,
    /// Awake share of the free nodes (1).
    pub share: f64,
    /// Error of the force at a quarter and at half a probe radius of depth [%]; `None` without
    /// equilibrium.
    pub error_pct: [Option<f64>; 2],
}

/// Smallest shares of the nodes that must be awake to keep a tolerance at a depth of half a probe
/// radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Needed {
    /// Number of nodes of the whole mesh.
    pub whole_nodes: usize,
    /// Distance of the press from the site [m].
    pub aside_m: f64,
    /// Allowed error of the force [%].
    pub tolerance_pct: f64,
    /// Smallest share that keeps the tolerance with all other nodes frozen (1); `None` if even 95 %
    /// of the nodes do not keep it.
    pub frozen_share: Option<f64>,
    /// Smallest share that keeps the tolerance with rim springs fitted to the springs of the
    /// outside (1); `None` if no patch that was tried keeps it.
    pub rim_springs_share: Option<f64>,
    /// Smallest share that keeps the tolerance with the product's rim springs, which are fitted to
    /// finite elements (1); `None` if no patch that was tried keeps it.
    pub rim_springs_from_elements_share: Option<f64>,
}

/// A region that the stress rule selects, and its force error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stress {
    /// Number of nodes of the whole mesh.
    pub whole_nodes: usize,
    /// Distance of the press from the site [m].
    pub aside_m: f64,
    /// Form of equation (8).
    pub pressure: ContactPressure,
    /// Contact pressure of (8) under the force of the whole mesh [Pa].
    pub contact_pa: f64,
    /// Smallest stress down to which the rule keeps nodes awake [Pa].
    pub least_stress_pa: f64,
    /// Radius that (7) gives [m].
    pub radius_m: f64,
    /// Awake share of the free nodes (1).
    pub share: f64,
    /// Error of the force at half a probe radius of depth [%]; `None` without equilibrium.
    pub error_pct: Option<f64>,
}

/// Results for all meshes and places.
#[derive(Clone, Debug, Default)]
pub struct Awake {
    /// Frozen regions and patches with rim springs.
    pub regions: Vec<Frozen>,
    /// Smallest shares of the nodes that must be awake.
    pub needed: Vec<Needed>,
    /// Regions that the stress rule selects.
    pub stress: Vec<Stress>,
}

/// Press of one whole mesh at one place.
struct Site<'a> {
    setting: &'a Setting,
    tissue: Tissue,
    statics: Statics,
    place_m: Vector,
    aside_m: f64,
    /// Distance of each free node from the press [m], with its index, in ascending order.
    away: Vec<(f64, usize)>,
    /// Force over E with every node awake [m^2], by depth.
    all: Vec<Option<f64>>,
}

/// Presses every mesh of the scope at every place, with a rising share of its nodes awake.
///
/// # Errors
/// Fails if the scene has no block, or if the block cannot be meshed.
pub fn awake(scene: &Scene, scope: &Scope, progress: &mut dyn FnMut(usize, usize, &str)) -> Result<Awake, Error> {
    let setting = Setting::of(scene, 0)?;
    faer::set_global_parallelism(faer::Par::Seq);
    let half = scene.tissue.block_m.map_or(0.0, |size| 0.5 * size[0]);
    // the whole contact must be on the block
    let fits = |aside: &&f64| setting.site_m.x + (**aside + 1.0) * setting.radius_m() <= half;
    let places: Vec<f64> = PLACES_RADII.iter().filter(fits).map(|p| p * setting.radius_m()).collect();
    let mut found = Awake::default();
    for (m, &nodes) in scope.awake_nodes.iter().enumerate() {
        let tissue = graded(scene, nodes)?;
        for (p, &aside_m) in places.iter().enumerate() {
            progress(m * places.len() + p, scope.awake_nodes.len() * places.len(), &format!("{nodes} nodes, awake shares"));
            let site = Site::of(&setting, tissue.clone(), aside_m)?;
            let frozen: Vec<Frozen> =
                SHARES.into_par_iter().map(|s| site.frozen(site.radius_m(s))).collect::<Result<_, Error>>()?;
            let patches: Vec<Vec<Frozen>> =
                PATCH_SHARES.into_par_iter().map(|s| site.held(site.radius_m(s))).collect::<Result<_, Error>>()?;
            let held: Vec<Frozen> = patches.into_iter().flatten().collect();
            let of = |kind: Surroundings| held.iter().filter(|h| h.held == kind).copied().collect::<Vec<_>>();
            let (springs, elements) = (of(Surroundings::SpringsOfSprings), of(Surroundings::SpringsOfElements));
            found.needed.extend(TOLERANCES_PCT.map(|tolerance_pct| Needed {
                whole_nodes: tissue.mesh.nodes_m.len(),
                aside_m,
                tolerance_pct,
                frozen_share: least(&frozen, tolerance_pct),
                rim_springs_share: least(&springs, tolerance_pct),
                rim_springs_from_elements_share: least(&elements, tolerance_pct),
            }));
            found.stress.extend(site.stress()?);
            found.regions.extend(frozen.into_iter().chain(held));
        }
    }
    Ok(found)
}

/// The smallest share from which on every larger one is within the tolerance.
fn least(regions: &[Frozen], tolerance_pct: f64) -> Option<f64> {
    let within = |r: &&Frozen| r.error_pct[1].is_some_and(|e| e.abs() <= tolerance_pct);
    regions.iter().rev().take_while(within).last().map(|r| r.share)
}

impl<'a> Site<'a> {
    fn of(setting: &'a Setting, mut tissue: Tissue, aside_m: f64) -> Result<Self, Error> {
        let place_m = setting.site_m + Vector::new(aside_m, 0.0, 0.0);
        // the foundation has a single stiffness, taken from the elements at the site
        tissue.site_m = place_m.into();
        let statics = Statics::of(&Patch::build(&tissue, &setting.material(), None).model(), &setting.params)?;
        let free = |n: &usize| tissue.anchors.binary_search(&(*n as u32)).is_err();
        let mut away: Vec<(f64, usize)> =
            (0..statics.rest_m.len()).filter(free).map(|n| ((statics.rest_m[n] - place_m).norm(), n)).collect();
        away.sort_by(|a, b| a.0.total_cmp(&b.0));
        let depths = DEPTHS_RADII.map(|d| d * setting.radius_m());
        let all = Setting::forces(&statics, &solver(&statics)?, place_m, &depths);
        Ok(Self { setting, tissue, statics, place_m, aside_m, away, all })
    }

    /// Radius of the ball around the press that contains this share of the free nodes [m].
    fn radius_m(&self, share: f64) -> f64 {
        let count = (share * self.away.len() as f64).round() as usize;
        self.away[count.clamp(1, self.away.len()) - 1].0
    }

    fn errors(&self, statics: &Statics) -> Result<[Option<f64>; 2], Error> {
        let depths = DEPTHS_RADII.map(|d| d * self.setting.radius_m());
        let forces = Setting::forces(statics, &solver(statics)?, self.place_m, &depths);
        Ok(std::array::from_fn(|k| Some(100.0 * (forces[k]? / self.all[k]? - 1.0))))
    }

    fn region(&self, radius_m: f64, awake: usize, held: Surroundings, error_pct: [Option<f64>; 2]) -> Frozen {
        let share = awake as f64 / self.away.len() as f64;
        Frozen { whole_nodes: self.statics.rest_m.len(), aside_m: self.aside_m, held, radius_m, share, error_pct }
    }

    /// Result with the nodes in the ball awake and all others frozen.
    fn frozen(&self, radius_m: f64) -> Result<Frozen, Error> {
        let asleep: Vec<usize> = self.away.iter().filter(|(away, _)| *away > radius_m).map(|(_, n)| *n).collect();
        let errors = self.errors(&self.statics.with_fixed(&asleep))?;
        Ok(self.region(radius_m, self.away.len() - asleep.len(), Surroundings::Frozen, errors))
    }

    /// Results of a patch of this radius with each of the two kinds of rim springs; empty if the
    /// patch cannot be cut.
    fn held(&self, radius_m: f64) -> Result<Vec<Frozen>, Error> {
        let sizes = Sizes { radius_m, fine_m: 0.0, fine_radius_m: 0.0, growth: 0.0, stroke_m: [0.0; 3] };
        let setting = self.setting;
        let Ok(far) = FarField::of(&self.tissue, &sizes, &setting.material(), &setting.params) else { return Ok(Vec::new()) };
        let free = Statics::of(&Patch::build(&far.cut.patch, &setting.material(), None).model(), &setting.params)?;
        let rim: Vec<usize> = far.cut.rim.iter().map(|n| *n as usize).collect();
        let exact_m = self.condensed_springs(&far)?;
        let reach_m = LOADS_RADII * setting.radius_m();
        let answers = rim_answers(&free, &far.cut, &exact_m, reach_m).map_err(|e| TissueError::Check(e.to_string()))?;
        let springs = springs::fit(&far.cut, &exact_m, &answers);
        let awake = far.cut.patch.mesh.nodes_m.len() - far.cut.patch.anchors.len();
        let mut found = Vec::new();
        for (kind, springs) in [(Surroundings::SpringsOfSprings, &springs), (Surroundings::SpringsOfElements, &far.springs)] {
            let errors = self.errors(&free.with_rim(&rim, &springs::dense(springs)))?;
            found.push(self.region(radius_m, awake, kind, errors));
        }
        Ok(found)
    }

    /// Stiffness over E [m] of the outside as springs, condensed to the rim. The compliance is
    /// computed with the rim also held by springs to the ground, which are subtracted after the
    /// inversion.
    fn condensed_springs(&self, far: &FarField) -> Result<Mat<f64>, Error> {
        let setting = self.setting;
        let outside = &far.cut.outside;
        let tissue = Tissue::closed(
            outside.mesh.clone(),
            outside.stiffness_ratio.clone(),
            outside.anchors.clone(),
            self.tissue.site_m,
            self.tissue.depth_limit_m,
        );
        let free = Statics::of(&Patch::build(&tissue, &setting.material(), None).model(), &setting.params)?;
        let rim: Vec<usize> = outside.rim.iter().map(|n| *n as usize).collect();
        let size = 3 * rim.len();
        let held_m = HELD_RADII * setting.radius_m();
        let held = free.with_rim(&rim, &Mat::from_fn(size, size, |r, c| if r == c { held_m } else { 0.0 }));
        // the probe is 1 m above the surface, so it does not touch
        let failed = |_| TissueError::Check("the outside is not stiff at rest: take another mesh".into());
        let rest = solver(&held)?.rest(&held, self.place_m, 1.0).map_err(failed)?;
        let mut compliance = Mat::zeros(size, size);
        for c in 0..size {
            let mut force = vec![Vector::zeros(); free.rest_m.len()];
            force[rim[c / 3]][c % 3] = 1.0;
            let moved = rest.answer(&held, &force);
            (0..size).for_each(|r| compliance[(r, c)] = moved[rim[r / 3]][r % 3]);
        }
        let both = compliance.partial_piv_lu().inverse();
        Ok(Mat::from_fn(size, size, |r, c| 0.5 * (both[(r, c)] + both[(c, r)]) - if r == c { held_m } else { 0.0 }))
    }

    /// Measures the regions selected by the stress rule, under both forms of (8).
    fn stress(&self) -> Result<Vec<Stress>, Error> {
        let params = &self.setting.params;
        let depth_m = DEPTHS_RADII[1] * self.setting.radius_m();
        let Some(force) = self.all[1] else { return Ok(Vec::new()) };
        let force_n = force * f64::from(params.youngs_modulus_pa);
        let mut found = Vec::new();
        for pressure in [ContactPressure::UniformLoad, ContactPressure::RigidPunch] {
            let contact_pa = StressRule::new(0.0, params.poisson_ratio, pressure).pressure_pa(
                params.youngs_modulus_pa,
                force_n as f32,
                depth_m as f32,
            );
            for share in THRESHOLDS {
                // both forms have the same threshold: a share of the lower of the two pressures,
                // which is the first one
                let least_stress_pa = found.first().map_or(f64::from(contact_pa), |s: &Stress| s.contact_pa) * share;
                let rule = StressRule::new(least_stress_pa as f32, params.poisson_ratio, pressure);
                let radius_m = f64::from(rule.radius_m(contact_pa, params.probe.radius_m));
                let region = self.frozen(radius_m)?;
                found.push(Stress {
                    whole_nodes: region.whole_nodes,
                    aside_m: self.aside_m,
                    pressure,
                    contact_pa: contact_pa.into(),
                    least_stress_pa,
                    radius_m,
                    share: region.share,
                    error_pct: region.error_pct[1],
                });
            }
        }
        Ok(found)
    }
}
