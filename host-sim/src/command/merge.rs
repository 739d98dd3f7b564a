//! The command `palpate merge`.

use std::path::PathBuf;

use clap::Args;

#[cfg(feature = "full")]
use super::accept::Accept;
use super::campaign::Campaign;
#[cfg(feature = "full")]
use super::chart::Chart;
use super::closed_loop::Loop;
use super::fault_hands::YieldingHands;
use super::fault_paths::Paths;
use super::faults::Faults;
#[cfg(feature = "full")]
use super::fit::FitScenes;
#[cfg(feature = "full")]
use super::plan::PlanScenes;
#[cfg(feature = "full")]
use super::stability::Stability;
use crate::error::Error;
use palpate_tissue::Error as TissueError;
use palpate_tissue::shard::{FILE, complete, program};

#[derive(Args, Clone, Debug)]
pub(super) struct MergeArgs {
    /// Folders of shards (shard-I-of-N), or folders that contain such folders, as given with --out
    /// when the shards ran.
    #[arg(value_name = "FOLDER", required = true)]
    folders: Vec<PathBuf>,
    /// Output folder of the merged result, created if missing; replaces an earlier result in it.
    #[arg(long, value_name = "FOLDER", default_value = "out/merged")]
    out: PathBuf,
    /// Print every row, as the campaign's command does with --all.
    #[arg(long)]
    all: bool,
}

impl MergeArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        if self.out.join(FILE).exists() {
            return Err(TissueError::Usage(format!(
                "--out {}: it is the folder of a shard, which the whole would replace: choose another folder",
                self.out.display()
            ))
            .into());
        }
        let parts = complete(&self.folders)?;
        let Some(heading) = parts.first().map(|part| &part.heading) else { return Ok(()) };
        match heading.command.as_str() {
            Faults::COMMAND | Paths::COMMAND | YieldingHands::COMMAND | Loop::COMMAND => {}
            // the command is built if this build lacks it, and run with the same arguments
            _ if cfg!(not(feature = "full")) => return super::on_demand::build_and_run(),
            _ => {}
        }
        let own = program().map_err(|source| TissueError::Read { path: "the program's own file".into(), source })?;
        if (heading.version.as_str(), &heading.program) != (env!("CARGO_PKG_VERSION"), &own) {
            return Err(TissueError::Usage(format!(
                "the shards are of program {} {}, this is {} {own}: merge with the program that ran them, or run them with this one",
                heading.version,
                heading.program,
                env!("CARGO_PKG_VERSION")
            ))
            .into());
        }
        let out = &self.out;
        match heading.command.as_str() {
            Faults::COMMAND => Faults::merge(parts, out, self.all),
            Paths::COMMAND => Paths::merge(parts, out, self.all),
            YieldingHands::COMMAND => YieldingHands::merge(parts, out, self.all),
            Loop::COMMAND => Loop::merge(parts, out, self.all),
            #[cfg(feature = "full")]
            Stability::COMMAND => Stability::merge(parts, out, self.all),
            #[cfg(feature = "full")]
            FitScenes::COMMAND => FitScenes::merge(parts, out, self.all),
            #[cfg(feature = "full")]
            PlanScenes::COMMAND => PlanScenes::merge(parts, out, self.all),
            #[cfg(feature = "full")]
            Chart::COMMAND => Chart::merge(parts, out, self.all),
            #[cfg(feature = "full")]
            Accept::COMMAND => Accept::merge(parts, out, self.all),
            other => {
                Err(TissueError::Usage(format!("this program knows no shards of {other}: merge with the one that ran them"))
                    .into())
            }
        }
    }
}
