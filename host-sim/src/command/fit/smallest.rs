//! `palpate fit --smallest`: the smallest piece that keeps the tolerance on a board.

use std::cell::Cell;

use palpate_fit::plan::{Bench, Supply, presses, search};
use palpate_fit::scene_fit::{Level, PiecePresses};
use palpate_fit::solved::Solved;
use palpate_tissue::budget::CostModel;
use palpate_tissue::scene::{Scene, SceneError};
use palpate_tissue::session::Session;

use super::super::progress::Progress;
use super::board::accepted;
use super::law::{LawFit, Whole};
use super::{Fitted, search_report};
use crate::command::options::fit::FitArgs;
use crate::error::Error;

/// Approximate number of steps of a quick search, in words.
const QUICK_STEPS: &str = " of some 20";

impl FitArgs {
    /// `for_law` says why a law does not answer the scene, if so.
    pub(super) fn fit_smallest(
        &self,
        scene: &Scene,
        for_law: Result<(), SceneError>,
        machine: &'static CostModel,
    ) -> Result<Fitted, Error> {
        let (quick, tolerance_pct) = (self.options.quick, self.options.tolerance_pct);
        let ceiling_n_per_m = self.options.device.ceiling_n_per_m()?;
        let status = Progress::start();
        let level = if quick { Level::Quick } else { Level::Full };
        let kept = Solved::beside(&self.common.folder("fit"));
        let (prepared, presses) = presses(scene, tolerance_pct, level, &kept, |what| status.say(what))?;
        let whole = Whole::prepared(scene, prepared);
        let mut folder = self.common.open("fit", scene)?;
        // removes the patch of an earlier search, which could be mistaken for that of this one
        folder.drop_earlier(&format!("{}-{}.patch", scene.name, machine.name));
        status.say("fitting a law");
        let law = for_law.map_err(|why| why.to_string()).and_then(|()| law(scene, machine, (&whole, &presses), tolerance_pct));
        match law {
            Ok((fitted, reason)) => {
                status.finish();
                let written = fitted.write(folder, scene, &self.options, format!("{}-{}.patch", scene.name, machine.name))?;
                println!("{reason}");
                return Ok(Fitted { patch: Some(written), trials: Vec::new(), missed: None });
            }
            Err(reason) => status.say(reason),
        }
        let (steps, of) = (Cell::new(0), if quick { QUICK_STEPS } else { "" });
        let progress = |what: &str| {
            steps.set(steps.get() + 1);
            status.say(format!("step {}{of}: {what}", steps.get()));
        };
        let on_board = |session: &Session| accepted(session, scene, machine);
        let bench = Bench { scene, machine, presses: &presses, tolerance_pct, quick, on_board: &on_board, progress: &progress };
        let outcome = search(&bench, &mut Supply::of(scene, machine, quick))?;
        status.finish();
        kept.said().iter().for_each(|line| println!("{line}"));
        let patch = search_report::write(folder, &bench, &outcome, ceiling_n_per_m, self.cases.all)?;
        let missed = outcome.check(machine, tolerance_pct).err().map(|missed| missed.to_string());
        Ok(Fitted { patch, trials: Vec::new(), missed })
    }
}

/// The law of the scene's site, with the reason why it is enough; otherwise the reason why it is
/// not.
fn law(
    scene: &Scene,
    machine: &CostModel,
    (whole, presses): (&Whole, &PiecePresses),
    tolerance_pct: f64,
) -> Result<(LawFit, String), String> {
    let mut fitted = LawFit::of_piece(scene, machine, whole, presses).map_err(|why| why.to_string())?;
    let reason = fitted.reason(scene, tolerance_pct)?;
    // a board that refuses the law gets a patch
    fitted.session = accepted(&fitted.session, scene, machine).ok_or_else(|| format!("{} refuses a law", machine.name))?;
    Ok((fitted, reason))
}
