//! `palpate cut`: cuts a patch out of a whole organ, with rim springs as its far field, and
//! calibrates it.

use palpate::{BuildError, Params};
use serde::Serialize;

use super::boards;
use super::options::cut::CutArgs;
use super::progress::Status;
use super::verdict::Verdict;
use crate::error::Error;
use palpate_board::live_trace;
use palpate_controller::link::Refusal;
use palpate_controller::patch::step;
use palpate_fit::calibrate::Round;
use palpate_fit::calibrate::accuracy::Accuracy;
use palpate_fit::calibrate::targets::DEPTHS_RADII;
use palpate_fit::far_field::fitted::{Fitted, JUDGED_PLACES, JUDGED_RADII, Prepared, Recipe, Short, Truth};
use palpate_fit::far_field::springs;
use palpate_fit::scene_fit::tissue_of;
use palpate_fit::solved::Solved;
use palpate_tissue::Error as TissueError;
use palpate_tissue::answer::AnswerProbe;
use palpate_tissue::budget::{Cost, CostModel, triangles_in_reach};
use palpate_tissue::fit_record::{FitRecord, Judged, Moving, OrganRecord, checksum};
use palpate_tissue::output::OutputFolder;
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;

/// Element sizes between which the smallest that fits is searched, if none is given [probe radii].
const ELEMENTS_RADII: [f64; 2] = [0.3, 0.9];
/// Number of halvings of this range, which leave a few tenths of a millimetre.
const HALVINGS: usize = 5;
/// Largest RMS error of an accepted fit [%].
const WORST_RMS_PCT: f64 = 10.0;
/// Range of depths over which the error is summarised [probe radii].
const JUDGED_DEPTHS_RADII: [f64; 2] = [0.125, 0.5];

/// Largest factor by which the mass floor of a fitted patch is raised, and smallest factor of one
/// step (1).
const MOST_FLOOR_RAISE: f32 = 2.0;
const FLOOR_STEP: f32 = 1.05;

impl CutArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let (common, machine, radius_m) = (&self.common, self.board.machine()?, self.radius_m);
        let ceiling_n_per_m = self.board.ceiling_n_per_m()?;
        let scene = common.load()?;
        scene.refuse_stiffening()?;
        if machine.is_board() {
            scene.refuse_what_boards_lack(machine.name)?;
        }
        let probe_m = scene.probe.radius_m;
        let recipe = |fine_m: f64| {
            let mut recipe = Recipe::new(radius_m, fine_m, probe_m);
            recipe.settings.places = self.places;
            if let Some([x, y]) = self.stroke_m.as_deref() {
                recipe.sizes.stroke_m = [*x, *y, 0.0];
            }
            recipe
        };
        let status = Status::start();
        let fine_m = match self.element_m {
            Some(fine_m) => fine_m,
            None => smallest_element(&scene, machine, probe_m, &recipe, &status)?,
        };
        let recipe = recipe(fine_m);
        let prepared = Prepared::of(&scene, &recipe)?;
        let before = cost(&prepared.patch(), &scene, machine, probe_m, 1);
        if before.units > before.budget {
            return Err(too_slow(&prepared.patch(), &before, machine));
        }
        let out = common.folder("cut");
        let folder = common.open("cut", &scene)?;
        status.say("finite elements of the whole");
        let solved = Solved::beside(&out);
        let truth = Truth::kept(&scene, &prepared.placed, Some(&solved), |done, all| {
            status.say(format!("finite elements of the whole: {done} of {all} presses"));
        })?;
        let mut rounds = 0;
        let fitted = prepared.fit(&truth, &recipe.settings, &mut |r: &Round| {
            rounds += 1;
            status.say(format!("fit: round {rounds}, force error {:.2} % rms", r.force_rms_pct));
        })?;
        let session = on_board(&fitted.patch, fitted.params, machine)?;
        let cost = cost(&session.patch, &scene, machine, scene.probe.tip().reach_m(), session.params.substeps);
        status.clear();
        solved.said().iter().for_each(|line| println!("{line}"));
        if cost.units > cost.budget {
            return Err(too_slow(&session.patch, &cost, machine));
        }
        let errors = fitted.short(0.124 * probe_m, 0.51 * probe_m);
        if errors.disc_rms_pct > WORST_RMS_PCT || !errors.disc_rms_pct.is_finite() {
            return Err(TissueError::Check(format!(
                "the fitted patch is {:.1} % rms off at unseen places, nothing is written: take smaller elements or a larger radius",
                errors.disc_rms_pct
            )).into());
        }
        write(folder, &scene, &prepared, &fitted, &session, (machine, ceiling_n_per_m), &cost)
    }
}

/// Cost of a tick with the scene's relaxation and friction, which the fit does not include.
fn cost(patch: &Patch, scene: &Scene, machine: &CostModel, radius_m: f64, substeps: u16) -> Cost {
    let radius_m = radius_m as f32;
    let model = patch.model();
    let site_m = patch.site_m();
    let touched = triangles_in_reach(&model, site_m.into(), radius_m);
    machine.cost_with(&model, &scene.params([0.0, 0.0, 1.0]), touched, substeps)
}

fn too_slow(patch: &Patch, cost: &Cost, machine: &CostModel) -> Error {
    Error::Tissue(TissueError::TooSlow(format!(
        "{} nodes take about {:.0} {} a tick, {:.0} fit on {}: take a larger --element, a smaller --radius or a faster board",
        patch.model().nodes.len(),
        cost.units,
        machine.unit,
        cost.budget,
        machine.name
    )))
}

/// Prepares a session of a fitted patch with a mass floor that a board accepts: the fit's
/// multipliers make nodes stiffer, and the masses of the floor may then be too light for one step
/// of 1 ms. Held forces do not depend on masses.
pub(super) fn on_board(patch: &Patch, mut params: Params, machine: &CostModel) -> Result<Session, Error> {
    let most = MOST_FLOOR_RAISE * params.mass_floor;
    loop {
        let session = Session::of_fitted(machine, patch.clone(), params)?;
        if !machine.is_board() || session.params.mass_floor >= most {
            return Ok(session);
        }
        let raise = match live_trace::fits(&packed(&session)) {
            Err(BuildError::OutOfRange { parameter: step::FLOOR, value, min, .. }) if value > 0.0 => min / value,
            _ if session.params.substeps > 1 => 1.0,
            _ => return Ok(session),
        };
        params.mass_floor = (params.mass_floor * raise.max(FLOOR_STEP)).min(most);
    }
}

pub(super) fn packed(session: &Session) -> Vec<u8> {
    session.patch.pack(&session.params, session.stable.pressed_s as f32)
}

/// Finds the smallest element with which a patch fits the machine in one substep.
fn smallest_element(
    scene: &Scene,
    machine: &CostModel,
    probe_m: f64,
    recipe: &impl Fn(f64) -> Recipe,
    status: &Status,
) -> Result<f64, Error> {
    let fits = |fine_m: f64| {
        status.say(format!("elements of {:.2} mm", fine_m * 1e3));
        let patch = Prepared::of(scene, &recipe(fine_m))?.patch();
        let cost = cost(&patch, scene, machine, probe_m, 1);
        if cost.units <= cost.budget { Ok(()) } else { Err(too_slow(&patch, &cost, machine)) }
    };
    let [mut small, mut large] = ELEMENTS_RADII.map(|r| r * probe_m);
    fits(large)?;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (small + large);
        if fits(middle).is_ok() { large = middle } else { small = middle }
    }
    Ok(large)
}

#[derive(Serialize)]
struct Summary<'a> {
    scene: &'a str,
    board: &'a str,
    nodes: usize,
    springs: usize,
    tets: usize,
    rim_nodes: usize,
    rim_edges: usize,
    rim_lowest_eigenvalue_over_e_m: f64,
    outside_tets: usize,
    radius_m: f64,
    element_m: f64,
    substeps: u16,
    stable_dt_s: f64,
    estimated_units: f64,
    budget_units: f64,
    unit: &'a str,
    fitted_places: u32,
    errors: Short,
    rounds: &'a [Round],
    accuracy: &'a Accuracy,
}

fn write(
    folder: OutputFolder,
    scene: &Scene,
    prepared: &Prepared,
    fitted: &Fitted,
    session: &Session,
    (machine, ceiling_n_per_m): (&CostModel, f32),
    cost: &Cost,
) -> Result<(), Error> {
    let model = session.patch.model();
    let radius_m = scene.probe.radius_m;
    let errors = fitted.short(0.124 * radius_m, 0.51 * radius_m);
    let (name, length) = write_patch(&folder, scene, session, (machine, ceiling_n_per_m), judged(&errors, radius_m), None)?;
    let rows = fitted
        .accuracy
        .forces
        .iter()
        .map(|f| [f.depth_mm, f.centred_pct, f.disc_rms_pct.unwrap_or(f64::NAN), f.disc_worst_pct.unwrap_or(f64::NAN)]);
    folder.write_csv("accuracy.csv", ["depth_mm", "centred_pct", "disc_rms_pct", "disc_worst_pct"], rows)?;
    folder.write_summary(&Summary {
        scene: &scene.name,
        board: machine.name,
        nodes: model.nodes.len(),
        springs: model.springs.len(),
        tets: model.tets.len(),
        rim_nodes: model.rim_nodes.len(),
        rim_edges: model.rim_edges.len(),
        rim_lowest_eigenvalue_over_e_m: springs::lowest_m(&prepared.far.springs),
        outside_tets: prepared.far.cut.outside.mesh.tets.len(),
        radius_m: model_radius_m(session),
        element_m: session.patch.element_m(),
        substeps: session.params.substeps,
        stable_dt_s: session.stable.pressed_s,
        estimated_units: cost.units,
        budget_units: cost.budget,
        unit: machine.unit,
        fitted_places: session.patch.fitted_places(),
        errors,
        rounds: &fitted.rounds,
        accuracy: &fitted.accuracy,
    })?;
    let out = folder.publish()?;
    let verdict = Verdict::ok(format!(
        "{} nodes, {:.2} % rms off finite elements of the whole (at most {WORST_RMS_PCT} % allowed) and {:+.2} % at worst, at places that the fit did not see; a tick takes {:.0} % of what it may on {} (estimate)",
        model.nodes.len(),
        errors.disc_rms_pct,
        errors.disc_worst_pct,
        100.0 * cost.units / cost.budget,
        machine.name
    ))
    .first();
    println!(
        "{}: {} nodes, {} springs, {} tets, {} bytes",
        out.join(&name).display(),
        model.nodes.len(),
        model.springs.len(),
        model.tets.len(),
        length
    );
    println!(
        "at its edge {} nodes, and springs along {} edges between them, stand in for the rest of the organ, {} tets that are not in the patch",
        model.rim_nodes.len(),
        model.rim_edges.len(),
        prepared.far.cut.outside.mesh.tets.len()
    );
    println!(
        "about {:.0} of at most {:.0} {} per tick on {} (estimate), {} substep(s) in a tick of 1 ms, a step is stable to {:.2} ms",
        cost.units,
        cost.budget,
        machine.unit,
        machine.name,
        session.params.substeps,
        session.stable.pressed_s * 1e3
    );
    println!(
        "force against finite elements of the whole: centred {:.2} % rms, unseen places {:.2} % rms, worst {:+.2} %",
        errors.centred_rms_pct, errors.disc_rms_pct, errors.disc_worst_pct
    );
    verdict.last()
}

/// Writes a patch of `cut` or `plan`, and the record of its fit beside it; returns the name of the
/// patch file and its length [bytes]. A patch that a board would refuse, for a device with this
/// stiffness ceiling [N/m], is not written.
pub(super) fn write_patch(
    folder: &OutputFolder,
    scene: &Scene,
    session: &Session,
    (machine, ceiling_n_per_m): (&CostModel, f32),
    judged: Judged,
    moving: Option<Moving>,
) -> Result<(String, usize), Error> {
    let name = format!("{}-{}.patch", scene.name, machine.name);
    let bytes = packed(session);
    if machine.is_board() {
        boards::refuse_contact(&name, boards::contact_refusal(&bytes, ceiling_n_per_m))?;
        live_trace::fits(&bytes).map_err(|cause| {
            TissueError::Check(format!(
                "{name}: {}; nothing is written, and smaller or larger elements may pass",
                Refusal::from(cause)
            ))
        })?;
    }
    folder.write(&name, &bytes)?;
    if let Some(patch_crc32) = checksum(&bytes) {
        record(scene, session, judged, moving, patch_crc32).write(folder, &name)?;
    }
    Ok((name, bytes.len()))
}

/// Converts the errors of a cut patch to the form of its record.
fn judged(errors: &Short, radius_m: f64) -> Judged {
    Judged {
        rms_pct: errors.disc_rms_pct,
        worst_pct: errors.disc_worst_pct,
        from_m: JUDGED_DEPTHS_RADII[0] * radius_m,
        to_m: JUDGED_DEPTHS_RADII[1] * radius_m,
        places: JUDGED_PLACES,
        lost_presses: 0,
        disc_radius_m: JUDGED_RADII * radius_m,
        bump: None,
        glued: None,
        surface: None,
    }
}

fn record(scene: &Scene, session: &Session, judged: Judged, moving: Option<Moving>, patch_crc32: u32) -> FitRecord {
    let radius_m = scene.probe.radius_m;
    FitRecord {
        patch_crc32,
        scene: scene.name.clone(),
        nodes: session.report.nodes,
        tissue: tissue_of(scene),
        organ: OrganRecord::of(scene),
        probe: AnswerProbe { shape: scene.probe.shape, radius_m },
        fitted_places: session.patch.fitted_places(),
        lost_fit_presses: 0,
        fitted_depths_m: DEPTHS_RADII.iter().map(|depth| depth * radius_m).collect(),
        judged,
        moving,
        reference_error_pct: None,
    }
}

/// Distance of the farthest node from the site [m].
fn model_radius_m(session: &Session) -> f64 {
    let site = session.patch.site_m();
    let model = session.patch.model();
    f64::from(model.nodes.iter().map(|n| (palpate::Vector3::from(n.rest_m) - site).norm()).fold(0.0, f32::max))
}

#[cfg(test)]
mod tests {
    use palpate_tissue::session::calibrated;

    use super::*;

    #[test]
    fn relaxation_and_friction_of_the_scene_are_counted() {
        let patch = calibrated::sized(130).unwrap().0;
        let machine = CostModel::named("m4f-168").unwrap();
        let of = |name: &str, friction: f64| {
            let mut scene = Scene::load(name).unwrap();
            scene.probe.friction = friction;
            cost(&patch, &scene, machine, 8e-3, 1).units
        };
        let [plain, relaxes, both] = [("block", 0.0), ("beef", 0.0), ("beef", 0.5)].map(|(name, friction)| of(name, friction));
        assert!(relaxes > plain + 1e4 && both > relaxes + 1e3, "{plain}, {relaxes}, {both}");
    }
    #[test]
    fn a_floor_that_is_too_light_for_a_board_is_raised() {
        let (patch, mut params) = calibrated::sized(130).unwrap();
        let machine = CostModel::named("m7-480").unwrap();
        let opened = |session: &Session| live_trace::fits(&packed(session)).map_err(Refusal::from);
        let kept = on_board(&patch, params, machine).unwrap();
        assert_eq!((kept.params.mass_floor, opened(&kept)), (params.mass_floor, Ok(())));
        params.mass_floor *= 0.5;
        let light = Session::of_fitted(machine, patch.clone(), params).unwrap();
        assert_eq!(opened(&light), Err(Refusal::PatchStep));
        let raised = on_board(&patch, params, machine).unwrap();
        assert!(raised.params.mass_floor > params.mass_floor && opened(&raised) == Ok(()), "{}", raised.params.mass_floor);
    }

    #[test]
    fn a_patch_has_the_record_of_its_fit_and_is_not_written_for_a_board_that_refuses_it() {
        let disk = tempfile::tempdir().unwrap();
        let scene = Scene::load("block").unwrap();
        let errors = Short { centred_rms_pct: 0.5, disc_rms_pct: 1.5, disc_worst_pct: -4.0 };
        let written = |board: &str, mass_floor: f32| {
            let (patch, params) = calibrated::sized(130).unwrap();
            let machine = CostModel::named(board).unwrap();
            let desktop = CostModel::named("desktop").unwrap();
            let mut session = Session::of_fitted(desktop, patch, params).unwrap();
            session.params.mass_floor = mass_floor;
            let folder = OutputFolder::open(&disk.path().join(board)).unwrap();
            let wrote = write_patch(&folder, &scene, &session, (machine, f32::MAX), judged(&errors, 8e-3), None);
            wrote.map(|(name, _)| folder.publish().unwrap().join(name))
        };
        let record = FitRecord::of_file(&written("desktop", 3.5).unwrap()).unwrap();
        assert_eq!((record.nodes, record.judged), (130, judged(&errors, 8e-3)));
        let refused = written("m7-480", 0.1).unwrap_err().to_string();
        assert!(refused.contains("more substeps or a larger mass floor; nothing is written"), "{refused}");
    }
}
