//! A scene prepared to run, with its patch, parameters, stable step and start-up report.

pub mod calibrated;
pub mod coarse;
pub mod moving;
pub mod packed;
pub mod standing;

use palpate::{GuardLimits, Params, Terms, Vector3};

use crate::budget::{CostModel, MACHINES, triangles_in_reach};
use crate::error::Error;
use crate::mesh::{ImportReport, SurfaceReport, WorstTet, worst};
use crate::patch::{Material, Patch};
use crate::recorded_tips::read_tips;
use crate::scene::{NO_PATCH, Scene, TICK_S, Tip};
use crate::stable_step::{MARGIN, StableStep, limits, substeps_for_taps};
use crate::tissue::{DEFAULT_NODES, Layout, place};

/// A scene ready to run.
#[derive(Clone, Debug)]
pub struct Session {
    /// Patch of the scene's tissue.
    pub patch: Patch,
    /// Parameters of the core, with the number of substeps that the patch needs.
    pub params: Params,
    /// Longest stable substeps, measured on the patch.
    pub stable: StableStep,
    /// Recorded tip positions of a trace [m]; empty if a finger presses.
    pub tips_m: Vec<[f32; 3]>,
    /// Start-up report that a user should see before anything moves.
    pub report: Report,
}

/// Start-up report, in which a wrong unit is easily noticed.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Report {
    /// Sides of the patch's bounding box [mm].
    pub size_mm: [f64; 3],
    /// Sum of the tets' volumes [cm^3].
    pub volume_cm3: f64,
    /// Volume that the surface file encloses, if the tets were made from one [cm^3].
    pub surface_cm3: Option<f64>,
    /// Box around the fixed nodes, lowest and highest corner [mm]; `None` if no node is fixed.
    pub fixed_mm: Option<[[f64; 3]; 2]>,
    /// Mass of the tissue [g].
    pub mass_g: f64,
    /// Mass of the nodes that move, with the mass floor, over their true mass (1).
    pub mass_floor_ratio: f64,
    /// Number of nodes.
    pub nodes: usize,
    /// Number of fixed nodes.
    pub anchors: usize,
    /// Number of springs.
    pub springs: usize,
    /// Number of tets.
    pub tets: usize,
    /// Number of surface triangles.
    pub triangles: usize,
    /// Index of the flattest tet.
    pub worst_tet: usize,
    /// Volume of that tet over the cube of its longest edge (1), scaled to 1 for the regular tet.
    pub worst_tet_quality: f64,
    /// Element size at the site [mm].
    pub element_mm: f64,
    /// Number of tets whose orientation the import reversed.
    pub flipped_tets: usize,
    /// Phrases for everything that the import left out or made of other elements.
    pub notes: Vec<String>,
    /// Longest stable substep at rest [ms].
    pub stable_rest_ms: f64,
    /// Longest stable substep during the press to the depth limit [ms].
    pub stable_pressed_ms: f64,
    /// Depth limit of the patch [mm].
    pub depth_limit_mm: f64,
    /// Number of substeps per tick.
    pub substeps: u16,
    /// Force error while the probe moves; `None` until [`Session::for_motion`] has judged it.
    pub moving: Option<moving::MovingReport>,
    /// Force expected at a depth of 1 mm on a half-space [N]: Hertz for a sphere, the rigid punch
    /// for a flat end.
    pub half_space_force_at_1mm_n: f64,
}

impl Session {
    /// Builds the patch of a scene and measures its stable step.
    ///
    /// # Errors
    /// Fails if the input is invalid, or if the model is too slow for 1 kHz; the message gives the
    /// numbers.
    pub fn prepare(scene: &Scene) -> Result<Self, Error> {
        Self::prepare_on(&MACHINES[0], scene)
    }

    /// Prepares a scene as [`Self::prepare`] does, with the variants of the model that `machine`
    /// runs.
    ///
    /// # Errors
    /// Errors of [`Self::prepare`].
    pub fn prepare_on(machine: &CostModel, scene: &Scene) -> Result<Self, Error> {
        let tips_m = read_tips(&scene.drive)?;
        if let Some(path) = scene.solver.patch.as_deref().filter(|p| p.as_os_str() != NO_PATCH) {
            let (patch, packed) = packed::open(scene, path)?;
            // a patch fitted as a whole block is homogeneous; any other was packed with its
            // inclusions
            let homogeneous = patch.fitted_places() > 0 && patch.model().rim_nodes.is_empty();
            let mut patch = if homogeneous { patch.with_inclusions(&scene.tissue.inclusion) } else { patch };
            steepen(scene, &mut patch)?;
            let mut params = fitted(scene, &packed);
            if patch.model().springs.is_empty() {
                params.stiffening_b = 0.0; // a law contains it
            }
            return Self::of_patch(machine, patch, params, tips_m, 0);
        }
        let placed = place(scene, &tips_m)?;
        if scene.solver.patch.is_none()
            && let Some((mut patch, packed)) = calibrated::of(scene, DEFAULT_NODES)
        {
            patch.set_site_m(placed.tissue.site_m);
            patch.set_depth_limit_m(placed.tissue.depth_limit_m as f32);
            steepen(scene, &mut patch)?;
            return Self::of_patch(machine, patch, fitted(scene, &packed), tips_m, 0);
        }
        if placed.import.is_some() {
            coarse::refuse(scene, &placed.tissue)?;
        }
        let params = scene.params(placed.axis);
        let material = Material { poisson_ratio: f64::from(params.poisson_ratio), ..Material::default() };
        let flipped = placed.import.as_ref().map_or(0, |i| i.flipped_tets);
        let mut patch = Patch::build(&placed.tissue, &material, None);
        steepen(scene, &mut patch)?;
        let mut session = Self::of_patch(machine, patch, params, tips_m, flipped)?;
        session.report.notes = (placed.import.iter().flat_map(ImportReport::notes))
            .chain(placed.surface.iter().flat_map(SurfaceReport::notes))
            .collect();
        session.report.surface_cm3 = placed.surface.map(|surface| surface.volume_m3 * 1e6);
        Ok(session)
    }

    /// Prepares a patch that was built elsewhere, with its parameters.
    ///
    /// # Errors
    /// A model that is too slow for 1 kHz; the message gives the numbers.
    pub fn of_fitted(machine: &CostModel, patch: Patch, params: Params) -> Result<Self, Error> {
        Self::of_patch(machine, patch, params, Vec::new(), 0)
    }

    fn of_patch(
        machine: &CostModel,
        patch: Patch,
        params: Params,
        tips_m: Vec<[f32; 3]>,
        flipped_tets: usize,
    ) -> Result<Self, Error> {
        let stiffens = params.terms.stiffening && params.stiffening_b > 0.0;
        let kept = stiffens.then(|| patch.clone());
        match (Self::try_patch(machine, patch, params, tips_m, flipped_tets), kept) {
            (Err(Error::TooSlow(why)), Some(patch)) => Err(Error::TooSlow(match most_stiffening(machine, &patch, &params) {
                Some(most_b) => {
                    format!(
                        "tissue.stiffening_b = {}: {why}; with this patch and depth at most {most_b} fits",
                        params.stiffening_b
                    )
                }
                None => why,
            })),
            (tried, _) => tried,
        }
    }

    fn try_patch(
        machine: &CostModel,
        patch: Patch,
        params: Params,
        tips_m: Vec<[f32; 3]>,
        flipped_tets: usize,
    ) -> Result<Self, Error> {
        let params = machine.adapt(&params);
        let own = limits(&patch, TICK_S);
        let max_sink_m_per_s = own.max_sink_m_per_s.min(params.limits.max_sink_m_per_s);
        let params = Params { limits: GuardLimits { max_sink_m_per_s, ..params.limits }, ..params };
        let model = patch.wide_model();
        let site_m = patch.site_m();
        let touched = triangles_in_reach(&model, site_m.into(), params.probe.reach_m());
        let fits = |measured| refuse_if_too_slow(&MACHINES[0], &model, &params, touched, measured);
        fits(None)?;
        let measured = StableStep::measure(&model, &params, site_m)?;
        let depth_mm = f64::from(model.depth_limit_m) * 1e3;
        let does_not_survive = || {
            Error::TooSlow(format!(
                "the tissue does not survive a press to {depth_mm:.1} mm, even with the smallest substeps tried: press less deep, or take another mesh or probe"
            ))
        };
        let stable = measured.ok_or_else(does_not_survive)?;
        let wanted = stable.substeps(TICK_S);
        fits(Some((wanted, &stable)))?;
        let substeps = substeps_for_taps(&model, &params, site_m, wanted as u16)?.ok_or_else(does_not_survive)?;
        fits(Some((f64::from(substeps), &stable)))?;
        let params = Params { substeps, ..params };
        let report = report(&patch, &params, &stable, flipped_tets)?;
        Ok(Self { patch, params, stable, tips_m, report })
    }

    /// Position of the tip for a depth along the press [m].
    #[must_use]
    pub fn tip_m(&self, depth_m: f64) -> Vector3<f32> {
        self.touch_m() - self.params.probe.axis * depth_m as f32
    }

    /// Position at which the tip touches the site [m]: the site itself, unless the tip is tilted.
    #[must_use]
    pub fn touch_m(&self) -> Vector3<f32> {
        self.patch.touch_m(&self.params)
    }
}

/// Sets the steepness of each node if the scene has regions or inclusions. Otherwise a packed patch
/// keeps its own steepness.
fn steepen(scene: &Scene, patch: &mut Patch) -> Result<(), Error> {
    let layout = Layout::of(scene)?;
    if !layout.is_uniform() {
        patch.set_steepness(layout.steepness(&patch.mesh(), scene.tissue.most_stiffening_b()));
    }
    Ok(())
}

/// The largest stiffening exponent with which a patch can run, rounded down to two digits; `None`
/// if it cannot run even without stiffening.
fn most_stiffening(machine: &CostModel, patch: &Patch, params: &Params) -> Option<f32> {
    let runs = |b: f32| {
        let params = Params { stiffening_b: b, ..*params };
        Session::try_patch(machine, patch.clone(), params, Vec::new(), 0).is_ok()
    };
    if !runs(0.0) {
        return None;
    }
    let mut halved = (0..MOST_HALVINGS).map(|n| params.stiffening_b * 0.5_f32.powi(n + 1));
    let (mut fits, mut fails) = halved.find(|b| runs(*b)).map_or((0.0, 0.0), |b| (b, 2.0 * b));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (fits + fails);
        if runs(middle) { fits = middle } else { fails = middle }
    }
    let digit = if fits > 0.0 { 10.0_f32.powf(fits.log10().floor() - 1.0) } else { 1.0 };
    Some((fits / digit).floor() * digit)
}

/// Largest number of times that an exponent is halved, in search of one with which the patch runs.
const MOST_HALVINGS: i32 = 10;
/// Number of bisections between that exponent and the one before.
const HALVINGS: usize = 3;

/// Parameters of the scene, except those that were fitted or lowered for a packed patch: they come
/// from its file.
fn fitted(scene: &Scene, packed: &Params) -> Params {
    let own = scene.params(packed.probe.axis.map(f64::from).into());
    // a patch fitted without a term must run without it
    let terms = Terms {
        volume: own.terms.volume && packed.terms.volume,
        compensation: own.terms.compensation && packed.terms.compensation,
        rim: own.terms.rim && packed.terms.rim,
        relative_mass: own.terms.relative_mass && packed.terms.relative_mass,
        smooth_mass: packed.terms.smooth_mass,
        // these are not fitted: they belong to the scene's tissue and probe
        stiffening: own.terms.stiffening,
        relaxation: own.terms.relaxation,
        friction: own.terms.friction,
        law: own.terms.law,
    };
    Params {
        compensation: packed.compensation,
        compensation_threshold: packed.compensation_threshold,
        mass_floor: packed.mass_floor,
        contact_damping: packed.contact_damping,
        limits: packed.limits,
        terms,
        ..own
    }
}

/// Refuses a model whose tick is too long with the substeps that it needs, measured or, before its
/// stable step is measured, at least one: measuring takes longer the larger the model is.
fn refuse_if_too_slow(
    machine: &CostModel,
    model: &palpate::Model,
    params: &Params,
    touched: usize,
    measured: Option<(f64, &StableStep)>,
) -> Result<(), Error> {
    let substeps = measured.map_or(1.0, |(substeps, _)| substeps);
    let cost = machine.cost_with(model, params, touched, substeps.min(f64::from(u16::MAX)) as u16);
    if cost.units <= cost.budget {
        return Ok(());
    }
    let nodes = model.nodes.len();
    let time = format!("about {:.0} us of the {:.0} us there are", cost.units * 1e-3, cost.budget * 1e-3);
    Err(Error::TooSlow(match measured {
        None => format!("cannot run at 1 kHz: {nodes} nodes need, with one substep a tick, {time}: take fewer nodes"),
        Some((_, stable)) => format!(
            "cannot run at 1 kHz: {nodes} nodes pressed to {:.1} mm need {substeps} substeps a tick (stable step {:.4} ms, {:.0} % of it used), {time}: take fewer nodes, press less deep, or take a more even mesh",
            f64::from(model.depth_limit_m) * 1e3,
            stable.pressed_s * 1e3,
            MARGIN * 100.0,
        ),
    }))
}

fn report(patch: &Patch, params: &Params, stable: &StableStep, flipped_tets: usize) -> Result<Report, Error> {
    let (mesh, model) = (patch.mesh(), patch.wide_model());
    let size_mm = [0, 1, 2].map(|k| {
        let (low, high) = mesh.nodes_m.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x[k]), h.max(x[k])));
        (high - low) * 1e3
    });
    let fixed = model.anchors.iter().map(|a| mesh.nodes_m[usize::from(*a)].map(|x| x * 1e3));
    let fixed_mm = fixed
        .map(|x| [x, x])
        .reduce(|[low, high], [x, _]| [[0, 1, 2].map(|k| low[k].min(x[k])), [0, 1, 2].map(|k| high[k].max(x[k]))]);
    let mut memory = crate::patch::Memory::for_model(&model);
    let (tuned, _) = memory.start(&model, params)?;
    let lumped = |n: usize| f64::from(params.density_kg_per_m3 * model.nodes[n].volume_m3);
    let moving = |n: &usize| tuned.mass_kg(*n).is_some_and(f32::is_finite);
    let moved: f64 = (0..model.nodes.len()).filter(moving).filter_map(|n| tuned.mass_kg(n)).map(f64::from).sum();
    let true_mass: f64 = (0..model.nodes.len()).filter(moving).map(lumped).sum();
    let worst_tet = worst(&mesh).unwrap_or(WorstTet { index: 0, quality: 1.0 });
    let (e, nu) = (f64::from(params.youngs_modulus_pa), f64::from(params.poisson_ratio));
    let plane_modulus = e / (1.0 - nu * nu);
    let half_space_force_at_1mm_n = Tip::of_core(&params.probe).half_space_m2(plane_modulus, 1e-3);
    Ok(Report {
        size_mm,
        volume_cm3: mesh.volume_m3() * 1e6,
        surface_cm3: None,
        fixed_mm,
        mass_g: (0..model.nodes.len()).map(lumped).sum::<f64>() * 1e3,
        mass_floor_ratio: moved / true_mass,
        nodes: model.nodes.len(),
        anchors: model.anchors.len(),
        springs: model.springs.len(),
        tets: model.tets.len(),
        triangles: model.triangles.len(),
        worst_tet: worst_tet.index,
        worst_tet_quality: worst_tet.quality,
        element_mm: patch.element_m() * 1e3,
        flipped_tets,
        notes: Vec::new(),
        stable_rest_ms: stable.rest_s * 1e3,
        stable_pressed_ms: stable.pressed_s * 1e3,
        depth_limit_mm: f64::from(model.depth_limit_m) * 1e3,
        substeps: params.substeps,
        moving: None,
        half_space_force_at_1mm_n,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tick_that_is_too_long_is_refused_with_the_substeps_that_it_needs() {
        let Session { patch, params, stable, .. } = Session::prepare(&Scene::load("block").unwrap()).unwrap();
        let refuse = |substeps| refuse_if_too_slow(&MACHINES[0], &patch.wide_model(), &params, 100, Some((substeps, &stable)));
        assert!(refuse(1.0).is_ok());
        let Err(Error::TooSlow(why)) = refuse(1000.0) else { panic!("a thousand substeps take longer than a tick") };
        let says = ["410 nodes pressed to ", "need 1000 substeps a tick", "us of the 1000 us", "fewer nodes"];
        assert!(says.into_iter().all(|words| why.contains(words)), "{why}");
    }
}
