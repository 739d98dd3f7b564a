//! Command line of `palpate plan`.

use std::path::PathBuf;

use clap::Args;
use palpate_tissue::Error as TissueError;
use serde::{Deserialize, Serialize};

use super::fit::check_tolerance;
use super::pack::{DeviceArg, machine};
use crate::command::Common;
use crate::command::campaign::Shards;
use crate::error::Error;

#[derive(Args, Clone, Debug)]
pub struct PlanArgs {
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub options: PlanOptions,
    /// Board, or budget, for a tick of the model: m4f-168 (Cortex-M4F, 168 MHz), m4f-170, m4f-180,
    /// m7-480 (Cortex-M7, 480 MHz), m7-400, m33-150 or desktop; nucleo-f446re, nucleo-g474re,
    /// nucleo-h743zi and pico2 select their own budget. With --scenes it may be given several
    /// times.
    #[arg(long, value_name = "BOARD", default_value = "m4f-168")]
    pub board: Vec<String>,
    /// Instead, plan every scene (.toml) of a folder for every board that is given, each into a
    /// folder of its own below --out, and collect the results in one table (plans.csv and
    /// summary.json in --out/table). For a scene that cannot be planned the row says why, and the
    /// exit code is 1.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["scene", "changes"])]
    pub scenes: Option<PathBuf>,
    #[command(flatten)]
    pub shards: Shards,
}

/// Options of the search for a model.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
pub struct PlanOptions {
    /// Largest tolerable force error [%]: root mean square over places and depths; single places
    /// may be off by 2.5 times as much.
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true)]
    pub tolerance_pct: f64,
    /// Try fewer and smaller candidates: 30 s of processor time for a block; an organ is solved by
    /// finite elements first, half a minute more.
    #[arg(long)]
    pub quick: bool,
    #[command(flatten)]
    #[serde(flatten)]
    pub device: DeviceArg,
}

impl PlanArgs {
    /// Checks whatever needs no search.
    ///
    /// # Errors
    /// The boards, the device, the scene or the tolerance cannot be used.
    pub fn check(&self) -> Result<(), Error> {
        self.board.iter().try_for_each(|board| machine(board).map(drop))?;
        self.options.device.ceiling_n_per_m()?;
        if self.scenes.is_none() {
            if self.shards.any() {
                let why = "--shard: one scene is planned in one piece, by a search whose steps follow from each other: leave it out, or give a folder of scenes with --scenes";
                return Err(TissueError::Usage(why.into()).into());
            }
            if self.board.len() != 1 {
                let boards = self.board.join(" --board ");
                return Err(TissueError::Usage(format!(
                    "--board {boards}: one scene is planned for one board: give one, or --scenes"
                ))
                .into());
            }
            self.common.load()?;
        }
        self.options.check()
    }
}

impl PlanOptions {
    /// Checks the numbers.
    ///
    /// # Errors
    /// The tolerance is out of its range.
    pub fn check(&self) -> Result<(), Error> {
        check_tolerance(self.tolerance_pct)
    }
}
