//! The command `palpate plan`.

mod report;
mod scenes;
mod worth;

use std::cell::Cell;
use std::path::Path;

pub(super) use self::scenes::PlanScenes;
use super::Common;
use super::campaign::Campaign;
use super::cut::{on_board, packed};
use super::options::pack::machine;
use super::options::plan::{PlanArgs, PlanOptions};
use super::progress::Status;
use crate::error::Error;
use crate::provenance;
use palpate_board::live_trace;
use palpate_fit::plan::{Bench, Known, Outcome, Supply, search};
use palpate_tissue::budget::CostModel;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;

/// Approximate number of steps of a quick search, in words.
const QUICK_STEPS: &str = " of some 20";

impl PlanArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let out = self.common.folder("plan");
        let boards = self.board.clone();
        if let Some(scenes) = self.scenes.clone() {
            let options = scenes::Options { plan: self.options.clone(), boards, scenes, out: out.clone() };
            return PlanScenes::start(options, &self.shards, &out);
        }
        let Some(board) = boards.first() else { return Ok(()) };
        let board = machine(board)?;
        let (outcome, _) = self.options.plan(&self.common, board, &out, self.shards.all)?;
        report::verdict(&outcome, board, self.options.tolerance_pct)?.last()
    }
}

impl PlanOptions {
    /// Plans one scene for one board, and writes the result to the folder `out`; also returns the
    /// name of the patch file. With `all`, every model that was tried is printed.
    fn plan(
        &self,
        common: &Common,
        machine: &'static CostModel,
        out: &Path,
        all: bool,
    ) -> Result<(Outcome, Option<String>), Error> {
        let (asked, ceiling_n_per_m) = (self.tolerance_pct, self.device.ceiling_n_per_m()?);
        let scene = common.load()?;
        scene.refuse_stiffening()?;
        if machine.is_board() {
            scene.refuse_what_boards_lack(machine.name)?;
        }
        let mut folder = OutputFolder::open(out)?.made_by(provenance::of(Some(&scene)));
        // removes the patch of an earlier plan, which could be mistaken for that of this one
        folder.drop_earlier(&format!("{}-{}.patch", scene.name, machine.name));
        let status = Status::start();
        let known = Known::of(&scene, asked, |what| status.say(what))?;
        let (steps, of) = (Cell::new(0), if self.quick { QUICK_STEPS } else { "" });
        let progress = |what: &str| {
            steps.set(steps.get() + 1);
            status.say(format!("step {}{of}: {what}", steps.get()));
        };
        let accepted = |session: &Session| accepted(session, &scene, machine);
        let bench = Bench {
            scene: &scene,
            machine,
            truth: &known.truth,
            judge: &known.judge,
            tolerance_pct: asked,
            quick: self.quick,
            on_board: &accepted,
            progress: &progress,
        };
        let outcome = search(&bench, &mut Supply::of(&scene, machine, self.quick))?;
        status.clear();
        let patch = report::write(folder, &bench, &outcome, ceiling_n_per_m, all)?;
        Ok((outcome, patch))
    }
}

/// The session as it is, or with a larger mass floor, if the machine accepts its patch.
fn accepted(session: &Session, scene: &Scene, machine: &CostModel) -> Option<Session> {
    let accepts = |session: &Session| !machine.is_board() || live_trace::fits(&packed(session)).is_ok();
    if accepts(session) {
        return Some(session.clone());
    }
    let raised = on_board(&session.patch, session.params, machine).ok()?;
    raised.for_motion_at_any_cost(machine, scene).ok().filter(accepts)
}

/// Returns the name of the unit of a cost in tables and charts, and the number by which the cost is
/// divided to have this unit.
fn unit(machine: &CostModel) -> (&'static str, f64) {
    if machine.unit == "ns" { ("us", 1e3) } else { ("k cycles", 1e3) }
}

#[cfg(test)]
mod tests {
    use palpate_tissue::session::calibrated;

    use super::*;

    #[test]
    fn a_patch_that_its_board_refuses_gets_a_larger_mass_floor_or_is_no_model() {
        let scene = Scene::load("block").unwrap();
        let machine = CostModel::named("m7-480").unwrap();
        let of = |share: f32| {
            let (patch, mut params) = calibrated::sized(130).unwrap();
            params.mass_floor *= share;
            let session = Session::of_fitted(machine, patch, params).unwrap();
            accepted(&session, &scene, machine).map(|kept| kept.params.mass_floor / session.params.mass_floor)
        };
        assert_eq!(of(1.0), Some(1.0));
        assert!(of(0.5).is_some_and(|raised| raised > 1.0));
        assert_eq!(of(0.02), None);
    }
}
