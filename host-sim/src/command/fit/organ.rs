//! `palpate fit` of a piece of an organ or a mesh.

use palpate_fit::far_field::fitted::{self, Recipe};
use palpate_fit::scene_fit::{Judging, Level, PIECE_JUDGED_RADII, PIECE_RADII, element_for, solve_organ};
use palpate_fit::solved::Solved;
use palpate_tissue::scene::Scene;

use super::super::progress::{Steps, told};
use super::Fitted;
use super::report::Report;
use super::stages::Stages;
use super::store::Store;
use crate::command::options::fit::FitArgs;
use crate::error::Error;

/// Number of nodes of a piece if none is given.
const NODES: usize = 100;
/// Share of the objective that a round must gain for the fit to continue; a round takes a second.
const LEAST_GAIN: f64 = 0.005;

impl FitArgs {
    pub(super) fn fit_organ(&self, scene: &Scene) -> Result<Fitted, Error> {
        let radius_m = self.options.radius_m.unwrap_or(PIECE_RADII * scene.probe.radius_m);
        let nodes = self.options.nodes.unwrap_or(NODES);
        let element_m = told("looking for the size of the elements", || element_for(scene, radius_m, nodes))?;
        let mut recipe = Recipe::new(radius_m, element_m, scene.probe.radius_m);
        recipe.points_per_triangle = self.options.points.unwrap_or(recipe.points_per_triangle);
        let prepared = told("cutting the piece out", || fitted::Prepared::of(scene, &recipe))?;
        let piece = prepared.patch();
        let nodes = piece.model().nodes.len();
        let path = self.common.folder("fit");
        let folder = self.common.open("fit", scene)?;
        let store = Store::of(&path, &folder, scene);
        let level = if self.options.quick { Level::Quick } else { Level::Full };
        let kept = Solved::beside(&path);
        let steps = Steps::new("finite elements", 0);
        let presses =
            solve_organ(scene, &prepared.placed, level, &kept, |done, all| steps.show(done, all, "presses of the whole"))?;
        steps.finish();
        self.print_scene(scene, nodes, recipe.points_per_triangle, &presses.fitted_m);
        kept.said().iter().for_each(|line| println!("{line}"));
        let stages = Stages { scene, known: &presses.known, store: &store, what: "fit" };
        let settings = self.settings(nodes, LEAST_GAIN);
        let problem = format!("{:?} {recipe:?} {settings:?} {:?}", store.pressed(), presses.answer.holds);
        let (fit, reused_fit) = stages.fit(&settings, &problem, |progress| presses.fit(&prepared, &settings, progress))?;
        let judging = Judging {
            known: &presses.known,
            fitted_m: &presses.fitted_m,
            unseen: &presses.unseen,
            disc_radii: PIECE_JUDGED_RADII,
        };
        let judged = stages.judge(&judging, (&piece, &prepared.params), &fit)?;
        store.write(std::iter::empty(), &[&fit])?;
        let report = Report {
            scene,
            fitted_m: &presses.fitted_m,
            known: &presses.known,
            answer: &presses.answer,
            reference_nodes: presses.nodes,
            reference_error: presses.error,
            fit: &fit,
            session: &judged.session,
            before: &judged.before,
            verdict: &judged.verdict,
            trials: &[],
            bump: None,
            reused_fit,
            reused_presses: kept.found(),
            places: settings.places,
            quick: self.options.quick,
            tolerance_pct: self.options.tolerance_pct,
        };
        Ok(self.judged(report.write(folder)?, &judged.verdict))
    }
}
