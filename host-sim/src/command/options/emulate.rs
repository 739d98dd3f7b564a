//! Command line of `palpate emulate`.

use std::path::PathBuf;

use clap::Args;

use palpate_tissue::Error as TissueError;

use super::EmulatedBoard;
use crate::command::Common;
use crate::error::Error;

#[derive(Args, Clone, Debug)]
pub struct EmulateArgs {
    #[command(flatten)]
    pub common: Common,
    /// Firmware image [default: built with `cargo fw`].
    #[arg(long, value_name = "FILE")]
    pub image: Option<PathBuf>,
    /// Packed patch to upload [default, by scene, from firmware/patches: block-m4f-168,
    /// nodule-m7-480 or liver-m4f-168].
    #[arg(long, value_name = "FILE")]
    pub patch: Option<PathBuf>,
    /// Emulated board [default: the one in the name of the patch file, else m4f-168].
    #[arg(long, value_enum)]
    pub board: Option<EmulatedBoard>,
    /// Ticks of random presses, faults and recovery after the scene's own press [default: 10000].
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    pub ticks: Option<u32>,
    /// Run only the press and 2000 ticks.
    #[arg(long)]
    pub quick: bool,
    /// Also measure the cost of a tick, the jitter of its start and the effect of late ticks
    /// (instructions.csv, overruns.csv, board.log, picture of all ticks).
    #[arg(long)]
    pub timing: bool,
}

impl EmulateArgs {
    /// Checks whatever needs no emulator.
    pub fn check(&self) -> Result<(), Error> {
        for path in [&self.image, &self.patch].into_iter().flatten() {
            std::fs::File::open(path).map_err(|source| TissueError::Read { path: path.clone(), source })?;
        }
        Ok(self.common.load()?.refuse_what_boards_lack("a board")?)
    }
}
