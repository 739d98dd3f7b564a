//! Command line of `palpate reference`.

use clap::Args;

use crate::command::Common;
use crate::error::Error;

#[derive(Args, Clone, Debug)]
pub struct ReferenceArgs {
    #[command(flatten)]
    pub common: Common,
    /// Use coarser meshes: 4 s of processor time for the block.
    #[arg(long)]
    pub quick: bool,
    /// Solve again the answers that ship with the project.
    #[arg(long, hide = true, conflicts_with_all = ["quick", "scene"])]
    pub shipped: bool,
}

impl ReferenceArgs {
    /// Checks whatever needs no finite elements.
    ///
    /// # Errors
    /// The scene cannot be read.
    pub fn check(&self) -> Result<(), Error> {
        self.common.load().map(drop)
    }
}
