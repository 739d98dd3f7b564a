//! `palpate plan`.

mod report;
mod worth;

use clap::Args;

use super::Common;
use super::pack::machine;
use super::progress::Status;
use crate::error::Error;
use palpate_fit::plan::{Bench, Known, Supply, search};
use palpate_tissue::budget::Machine;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;

#[derive(Args, Clone, Debug)]
pub(super) struct PlanArgs {
    #[command(flatten)]
    common: Common,
    /// Force error that is bearable [%]: root mean square over places and depths; single places may
    /// be 2.5 times as far off.
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    tolerance_pct: f64,
    /// Board whose budget a tick of the model must meet: m4f-168 (Cortex-M4F, 168 MHz), m7-480
    /// (Cortex-M7, 480 MHz) or desktop.
    #[arg(long, value_name = "BOARD", default_value = "m4f-168")]
    board: String,
    /// Fewer and smaller candidates: under a minute for a block.
    #[arg(long)]
    quick: bool,
}

impl PlanArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let machine = machine(&self.board)?;
        let asked = self.tolerance_pct;
        let scene = Scene::load(&self.common.scene)?;
        scene.refuse_stiffening()?;
        if machine.is_board() {
            scene.refuse_what_boards_lack(machine.name)?;
        }
        let mut folder = OutputFolder::open(&self.common.folder("plan"))?;
        // an earlier plan's patch must not be taken for this one's
        folder.drop_earlier(&format!("{}-{}.patch", scene.name, machine.name));
        let status = Status::start();
        let known = Known::of(&scene, asked, |what| status.say(what))?;
        let progress = |what: &str| status.say(what);
        let bench = Bench {
            scene: &scene,
            machine,
            truth: &known.truth,
            judge: &known.judge,
            tolerance_pct: asked,
            quick: self.quick,
            progress: &progress,
        };
        let outcome = search(&bench, &mut Supply::of(&scene, machine, self.quick))?;
        status.clear();
        report::write(folder, &bench, &outcome)?;
        Ok(outcome.check(machine, asked).map(|_| ())?)
    }
}

/// Returns the name of the unit of a cost in tables and charts, and the number that the cost is
/// divided by there.
fn unit(machine: &Machine) -> (&'static str, f64) {
    if machine.unit == "ns" { ("us", 1e3) } else { ("k cycles", 1e3) }
}
