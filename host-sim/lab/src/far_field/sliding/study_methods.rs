//! Methods for sliding: patches long enough for the stroke, and alternatives.
//!
//! A stationary patch that is too small for the stroke shows the limits of a far field. A round
//! patch that is large enough shows how much the elongated shape saves. The stroke patch with a
//! fixed rim shows the effect of the rim springs. The whole block with the frozen outside of paper
//! 004 is the papers' solution. Two alternatives were not built. A patch that travels with the
//! probe has no ripple up to 50 mm/s, but works in homogeneous flat tissue only, and if it includes
//! the velocity of its frame, it drives the probe on and creates energy. With far fields blended
//! from place to place a tick would have to mix their blocks, and the elements would still stay in
//! place.

use crate::paper_method::region::{ContactPressure, StressRule};
use palpate::Params;

use super::run::Awake;
use super::trajectory::Trajectory;
use crate::error::Error;
use palpate_fit::calibrate::reference_map::ReferenceMap;
use palpate_fit::calibrate::targets::GLUED_TOLERANCE;
use palpate_fit::calibrate::{Settings, Targets, calibrate};
use palpate_fit::far_field::{FarField, Sizes};
use palpate_fit::statics::{Statics, Vector};
use palpate_tissue::Error as TissueError;
use palpate_tissue::mesh::block_with_rim;
use palpate_tissue::patch::{Material, Multipliers, Patch};
use palpate_tissue::scene::Scene;
use palpate_tissue::scene::TICK_S;
use palpate_tissue::session::calibrated::sized;
use palpate_tissue::stable_step::{StableStep, limits, substeps_for_taps};
use palpate_tissue::tissue::{Placed, place_block};

/// Largest distance of fitted places from the path, to either side [probe radii]: about the radius
/// of the contact.
const HALF_WIDTH_RADII: f64 = 0.625;
/// Radius of the disc of fitted places of a stationary patch [probe radii].
const DISC_RADII: f64 = 1.15;
/// Number of nodes of the shipped whole block.
const WHOLE_NODES: usize = 410;

/// Kind of method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A patch with rim springs, as long as the stroke: the product's method.
    Stroke,
    /// A patch as long as the stroke, with a fixed rim.
    Fixed,
    /// A round patch with rim springs at the middle of the stroke, fitted around its site.
    Stays,
    /// A round patch with rim springs that contains the whole stroke, fitted along it.
    Round,
    /// The whole block with every node active.
    Whole,
    /// The whole block, its outside frozen by the stress rule of paper 004.
    StressRule,
    /// A stroke patch whose nodes sleep while they are at rest.
    Sleeping,
}

impl Kind {
    /// Name in a table.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Stroke => "stroke",
            Self::Fixed => "fixed",
            Self::Stays => "stays",
            Self::Round => "round",
            Self::Whole => "whole",
            Self::StressRule => "stress-rule",
            Self::Sleeping => "sleeping",
        }
    }

    /// Name in a legend.
    fn short(self) -> &'static str {
        match self {
            Self::Stroke => "stroke patch (ours)",
            Self::Fixed => "same, rim fixed",
            Self::Stays => "patch that stays",
            Self::Round => "large round patch",
            Self::Whole => "whole block",
            Self::StressRule => "stress rule",
            Self::Sleeping => "same, sleeping",
        }
    }
}

/// Displacement that the force on a sleeping node would cause for it to wake [m].
const WAKES_M: f64 = 1e-5;

/// A patch, its parameters, and the choice of its active nodes.
#[derive(Clone, Debug)]
pub struct StudyMethod {
    /// Kind of method.
    pub kind: Kind,
    /// Name in tables, unique among the methods.
    pub name: String,
    /// Name in a legend.
    pub short: String,
    /// Patch on which the probe slides.
    pub patch: Patch,
    /// Parameters, with the substeps that it needs.
    pub params: Params,
    /// Stable step of the method [s].
    pub stable_s: f64,
    /// Choice of the nodes that are active.
    pub awake: Awake,
    /// Statics of the patch with the dense condensed outside; `None` for patches without one.
    pub exact: Option<Statics>,
}

/// Recipe of a patch with rim springs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokeRecipe {
    /// Sizes of the patch, of its elements and of the stroke.
    pub sizes: Sizes,
    /// Number of the mesh among those of the same sizes.
    pub variant: u32,
    /// Foundation points per triangle: 4 or 9, or 16, which boards do not support.
    pub points_per_triangle: usize,
    /// Settings of the fit, such as its number of places and rounds.
    pub settings: Settings,
}

impl StrokeRecipe {
    /// Recipe of a patch of radius `radius_m` with elements of size `fine_m` for the stroke
    /// `stroke_m` under a probe of radius `probe_radius_m`.
    #[must_use]
    pub fn new(radius_m: f64, fine_m: f64, stroke_m: [f64; 3], probe_radius_m: f64) -> Self {
        Self {
            sizes: Sizes { radius_m, fine_m, fine_radius_m: probe_radius_m, growth: 0.5, stroke_m },
            variant: 0,
            points_per_triangle: 9,
            settings: Settings { places: 60, rounds: 6, ..Settings::default() },
        }
    }
}

/// A fitted patch with rim springs.
#[derive(Clone, Debug)]
pub struct StrokePatch {
    /// Cut, condensed outside and rim springs.
    pub far: FarField,
    /// Constants of the material.
    pub material: Material,
    /// Multipliers that were fitted.
    pub multipliers: Multipliers,
    /// Patch on which the probe slides.
    pub patch: Patch,
    /// Parameters with the fitted scalars.
    pub params: Params,
}

impl StrokePatch {
    /// Cuts a patch out of the block of a scene and fits it to places along `trajectory` and to
    /// both sides of it, or around the site if there is no trajectory.
    ///
    /// # Errors
    /// Fails if the sizes do not fit the block, if the reference does not cover the path, or if the
    /// patch cannot be pressed.
    pub fn fit(
        scene: &Scene,
        recipe: &StrokeRecipe,
        trajectory: Option<&Trajectory>,
        reference: &ReferenceMap,
    ) -> Result<Self, Error> {
        let refused = |cause: &dyn std::fmt::Display| TissueError::Usage(format!("{}: {cause}", scene.file));
        let Placed { tissue, axis, .. } = whole_block(scene, recipe)?;
        let params = scene.params(axis);
        let poisson_ratio = scene.tissue.poisson_ratio;
        let material = Material { poisson_ratio, points_per_triangle: recipe.points_per_triangle, ..Material::default() };
        let far = FarField::of(&tissue, &recipe.sizes, &material, &params).map_err(|cause| refused(&cause))?;
        let (site_m, radius_m) = (Vector::from(tissue.site_m), scene.probe.radius_m);
        let places = recipe.settings.places;
        let targets = match trajectory {
            Some(trajectory) => {
                let stroke_m = trajectory.stroke_m.into();
                Targets::over_a_stroke(reference, site_m, stroke_m, HALF_WIDTH_RADII * radius_m, radius_m, places)
            }
            None => Targets::over_a_disc(reference, &[], site_m, radius_m, DISC_RADII, places),
        };
        let unknown = || refused(&"the reference does not know the whole stroke: make it shorter");
        // presses alone would not determine the rim's response in shear
        let centred: Vec<_> = reference.glued().iter().filter(|disc| disc.place_m == [0.0; 3]).cloned().collect();
        let targets = targets.ok_or_else(unknown)?.with_glued(&centred, GLUED_TOLERANCE);
        let fit = calibrate(&far.cut.patch, &material, Some(&far.springs), &params, &targets, &recipe.settings, &mut |_| ())
            .map_err(|cause| TissueError::Check(format!("the patch cannot be fitted: {cause}")))?;
        Ok(Self { far, material, multipliers: fit.multipliers, patch: fit.patch, params: fit.params })
    }

    /// Builds the patch with a fixed rim.
    #[must_use]
    pub fn with_fixed_rim(&self) -> Patch {
        let mut tissue = self.far.cut.patch.clone();
        tissue.anchors.extend(&self.far.cut.rim);
        tissue.anchors.sort_unstable();
        Patch::build(&tissue, &self.material, Some(&self.multipliers))
    }

    fn method(&self, kind: Kind, name: String) -> Result<StudyMethod, Error> {
        let rim: Vec<usize> = self.far.cut.rim.iter().map(|n| *n as usize).collect();
        let exact = Statics::of(&self.patch.model(), &self.params)?.with_rim(&rim, &self.far.exact_m);
        Ok(StudyMethod { exact: Some(exact), ..StudyMethod::new(kind, name, self.patch.clone(), &self.params, Awake::All)? })
    }
}

/// The block of a scene with a mesh refined along the stroke of the patch.
pub(super) fn whole_block(scene: &Scene, recipe: &StrokeRecipe) -> Result<Placed, Error> {
    let size_m =
        scene.tissue.block_m.ok_or_else(|| TissueError::Usage(format!("{}: sliding is measured on a block", scene.file)))?;
    let at_m = scene.probe.position_m.unwrap_or_default();
    let mesh = block_with_rim(size_m, at_m, &recipe.sizes, recipe.variant)
        .map_err(|cause| TissueError::Usage(format!("{}: {cause}", scene.file)))?;
    Ok(place_block(scene, &[], mesh)?)
}

impl StudyMethod {
    /// Determines the limits and the number of substeps that the patch needs.
    ///
    /// # Errors
    /// A patch that does not survive a press.
    pub fn new(kind: Kind, name: String, patch: Patch, params: &Params, awake: Awake) -> Result<Self, Error> {
        let short = kind.short().into();
        let params = Params { limits: limits(&patch, TICK_S), substeps: 1, ..*params };
        let (model, site_m) = (patch.wide_model(), patch.site_m());
        let dies = || TissueError::Check(format!("{name} does not survive a press"));
        let stable = StableStep::measure(&model, &params, site_m)?.ok_or_else(dies)?;
        let wanted = stable.substeps(TICK_S) as u16;
        let substeps = substeps_for_taps(&model, &params, site_m, wanted)?.ok_or_else(dies)?;
        Ok(Self {
            kind,
            name,
            short,
            params: Params { substeps, ..params },
            stable_s: stable.pressed_s,
            awake,
            exact: None,
            patch,
        })
    }

    /// A patch with rim springs, fitted along the path; with `and_others` also that patch with a
    /// fixed rim, and with sleeping nodes.
    pub(super) fn stroke(
        scene: &Scene,
        recipe: &StrokeRecipe,
        trajectory: &Trajectory,
        reference: &ReferenceMap,
        and_others: bool,
    ) -> Result<Vec<Self>, Error> {
        let fitted = StrokePatch::fit(scene, recipe, Some(trajectory), reference)?;
        let round = recipe.sizes.stroke_m == [0.0; 3];
        let (kind, shape) = if round { (Kind::Round, "round patch") } else { (Kind::Stroke, "stroke patch") };
        let size = size_of(recipe, &fitted.patch);
        let mut all = vec![fitted.method(kind, format!("{shape} {size}"))?];
        if and_others {
            let name = format!("{shape} {size} rim fixed");
            all.push(Self::new(Kind::Fixed, name, fitted.with_fixed_rim(), &fitted.params, Awake::All)?);
            let name = format!("{shape} {size} sleeping");
            let short = Kind::Sleeping.short().into();
            all.push(Self { kind: Kind::Sleeping, name, short, awake: Awake::Moving(WAKES_M), ..all[0].clone() });
        }
        Ok(all)
    }

    /// A round stationary patch.
    pub(super) fn stays(scene: &Scene, recipe: &StrokeRecipe, reference: &ReferenceMap) -> Result<Self, Error> {
        let fitted = StrokePatch::fit(scene, recipe, None, reference)?;
        fitted.method(Kind::Stays, format!("patch that stays {}", size_of(recipe, &fitted.patch)))
    }

    /// The shipped block with every node active, and with its outside frozen by the stress rule at
    /// each threshold [Pa].
    pub(super) fn whole(least_stresses_pa: &[f64]) -> Result<Vec<Self>, Error> {
        let missing = || TissueError::Check(format!("no block of {WHOLE_NODES} nodes is shipped"));
        let (patch, params) = sized(WHOLE_NODES).ok_or_else(missing)?;
        let all = Self::new(Kind::Whole, format!("whole block {WHOLE_NODES} nodes"), patch, &params, Awake::All)?;
        let frozen = least_stresses_pa.iter().map(|&least_pa| {
            let rule = StressRule::new(least_pa as f32, params.poisson_ratio, ContactPressure::UniformLoad);
            let name = format!("stress rule {least_pa:.0} Pa");
            Self { kind: Kind::StressRule, short: name.clone(), name, awake: Awake::Stressed(rule), ..all.clone() }
        });
        let frozen: Vec<Self> = frozen.collect();
        Ok(std::iter::once(all).chain(frozen).collect())
    }
}

fn size_of(recipe: &StrokeRecipe, patch: &Patch) -> String {
    let sizes = &recipe.sizes;
    let nodes = patch.model().nodes.len();
    let mesh = (b'a' + (recipe.variant % 26) as u8) as char;
    format!("R {:.0} h {:.1} mm {mesh} {nodes} nodes", sizes.radius_m * 1e3, sizes.fine_m * 1e3)
}
