//! The command `palpate plan`.

mod report;
mod scenes;
mod worth;

use std::cell::Cell;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::{Deserialize, Serialize};

pub(super) use self::scenes::PlanScenes;
use super::Common;
use super::boards::machine;
use super::campaign::{Campaign, Shards};
use super::cut::{on_board, packed};
use super::pack::DeviceArg;
use super::progress::Status;
use crate::error::Error;
use crate::provenance;
use palpate_board::live_trace;
use palpate_fit::plan::{Bench, Known, Outcome, Supply, search};
use palpate_tissue::Error as TissueError;
use palpate_tissue::budget::CostModel;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;

/// Approximate number of steps of a quick search, in words.
const QUICK_STEPS: &str = " of some 20";

#[derive(Args, Clone, Debug)]
pub(super) struct PlanArgs {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    options: PlanOptions,
    /// Board, or budget, for a tick of the model: m4f-168 (Cortex-M4F, 168 MHz), m4f-170, m4f-180,
    /// m7-480 (Cortex-M7, 480 MHz), m7-400, m33-150 or desktop; nucleo-f446re, nucleo-g474re,
    /// nucleo-h743zi and pico2 select their own budget. With --scenes it may be given several
    /// times.
    #[arg(long, value_name = "BOARD", default_value = "m4f-168")]
    board: Vec<String>,
    /// Instead, plan every scene (.toml) of a folder for every board that is given, each into a
    /// folder of its own below --out, and collect the results in one table (plans.csv and
    /// summary.json in --out/table). For a scene that cannot be planned the row says why, and the
    /// exit code is 1.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["scene", "changes"])]
    scenes: Option<PathBuf>,
    #[command(flatten)]
    shards: Shards,
}

/// Options of the search for a model.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
pub(super) struct PlanOptions {
    /// Largest tolerable force error [%]: root mean square over places and depths; single places
    /// may be off by 2.5 times as much.
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    tolerance_pct: f64,
    /// Try fewer and smaller candidates: 30 s of processor time for a block; an organ is solved by
    /// finite elements first, half a minute more.
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    #[serde(flatten)]
    device: DeviceArg,
}

impl PlanArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let out = self.common.folder("plan");
        let boards = self.board.clone();
        if let Some(scenes) = self.scenes.clone() {
            let options = scenes::Options { plan: self.options.clone(), boards, scenes, out: out.clone() };
            return PlanScenes::start(options, &self.shards, &out);
        }
        if self.shards.any() {
            let why = "--shard: one scene is planned in one piece, by a search whose steps follow from each other: leave it out, or give a folder of scenes with --scenes";
            return Err(TissueError::Usage(why.into()).into());
        }
        let [board] = &boards[..] else {
            let why = format!("--board {}: one scene is planned for one board: give one, or --scenes", boards.join(" --board "));
            return Err(TissueError::Usage(why).into());
        };
        let board = machine(board)?;
        let (outcome, _) = self.options.plan(&self.common, board, &out, self.shards.all)?;
        report::verdict(&outcome, board, self.options.tolerance_pct)?.last()
    }
}

impl PlanOptions {
    fn check(&self) -> Result<(), Error> {
        if self.tolerance_pct > 0.0 && self.tolerance_pct <= 100.0 {
            return Ok(());
        }
        let why = format!("--tolerance-pct {}: give a percentage above 0, at most 100", self.tolerance_pct);
        Err(TissueError::Usage(why).into())
    }

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
