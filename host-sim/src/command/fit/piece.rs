//! `palpate fit` of a piece of a block, an organ or a mesh.

use palpate_fit::far_field::prepared::{Prepared, Recipe};
use palpate_fit::scene_fit::{Judging, Level, PIECE_JUDGED_RADII, PIECE_RADII, PLACES, PiecePresses, element_for};
use palpate_fit::solved::Solved;
use palpate_tissue::budget::{CostModel, MACHINES};
use palpate_tissue::scene::Scene;

use super::super::progress::{Progress, told};
use super::board::{Load, file, smallest_element};
use super::report::Report;
use super::stages::Stages;
use super::store::Store;
use super::{Fitted, PatchFile};
use crate::command::options::fit::FitArgs;
use crate::error::Error;

/// Number of nodes of a piece if none is given.
const NODES: usize = 100;
/// Share of the objective that a round must gain for the fit to continue; a round takes a second.
const LEAST_GAIN: f64 = 0.005;

impl FitArgs {
    pub(super) fn fit_piece(&self, scene: &Scene, machine: Option<&CostModel>) -> Result<Fitted, Error> {
        let options = &self.options;
        let radius_m = options.radius_m.unwrap_or(PIECE_RADII * scene.probe.radius_m);
        let recipe = |element_m: f64| {
            let mut recipe = Recipe::new(radius_m, element_m, scene.probe.radius_m);
            recipe.points_per_triangle = options.points.unwrap_or(recipe.points_per_triangle);
            recipe
        };
        let looking = "looking for the size of the elements";
        let element_m = match (options.element_m, machine, options.nodes) {
            (Some(element_m), ..) => element_m,
            (None, Some(machine), None) => told(looking, || smallest_element(scene, machine, &recipe))?,
            (None, _, nodes) => told(looking, || element_for(scene, radius_m, nodes.unwrap_or(NODES)))?,
        };
        let recipe = recipe(element_m);
        let prepared = told("cutting the piece out", || Prepared::of(scene, &recipe))?;
        let piece = prepared.patch();
        let nodes = piece.model().nodes.len();
        machine.map(|machine| Load::of(&piece, scene, machine, 1).check(nodes)).transpose()?;
        let path = self.common.folder("fit");
        let folder = self.common.open("fit", scene)?;
        let store = Store::of(&path, &folder, scene);
        let level = if options.quick { Level::Quick } else { Level::Full };
        let kept = Solved::beside(&path);
        let steps = Progress::new(0, "finite elements");
        let presses = PiecePresses::of(scene, &prepared.placed, (level, machine.is_some()), &kept, |done, all| {
            steps.show(done, all, "presses of the whole");
        })?;
        steps.finish();
        self.print_scene(scene, nodes, recipe.points_per_triangle, &presses.fitted_m);
        kept.said().iter().for_each(|line| println!("{line}"));
        let stages = Stages { scene, known: presses.known.reference(), store: &store, what: "fit" };
        let settings = self.settings(nodes, LEAST_GAIN);
        let problem = format!("{:?} {recipe:?} {settings:?} {:?} {:?}", store.pressed(), presses.fitted_m, presses.answer.holds);
        let (fit, reused_fit) = stages.fit(&settings, &problem, |progress| presses.fit_piece(&prepared, &settings, progress))?;
        let judging = Judging {
            known: presses.known.reference(),
            fitted_m: &presses.fitted_m,
            unseen: &presses.unseen,
            disc_radii: PIECE_JUDGED_RADII,
            places: PLACES,
            reference_error: presses.error,
        };
        let judged = stages.judge(&judging, (&piece, &prepared.params), &fit, machine.unwrap_or(&MACHINES[0]))?;
        let mut patch = PatchFile { name: format!("{}-{nodes}.patch", scene.name), bytes: fit.patch(), load: None };
        if let Some(machine) = machine {
            let load = Load::of(&judged.session.patch, scene, machine, judged.session.params.substeps).check(nodes)?;
            let (name, bytes) = file(&judged.session, scene, machine, options.device.ceiling_n_per_m()?)?;
            patch = PatchFile { name, bytes, load: Some(load) };
        }
        store.write(std::iter::empty(), &[&fit])?;
        let report = Report {
            scene,
            options,
            fitted_m: &presses.fitted_m,
            known: presses.known.reference(),
            answer: &presses.answer,
            reference_nodes: presses.nodes,
            reference_error: presses.error,
            fit: &fit,
            judged: &judged,
            trials: &[],
            bump: None,
            reused_fit,
            reused_presses: kept.found(),
            places: settings.places,
        };
        Ok(self.judged(report.write(folder, patch)?, &judged.verdict))
    }
}
