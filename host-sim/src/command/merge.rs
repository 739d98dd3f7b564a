//! The command `palpate merge`.

use std::path::PathBuf;

use clap::Args;

use super::campaign::Campaign;
use super::closed_loop::Loop;
#[cfg(feature = "full")]
use super::fit::FitScenes;
use super::on_demand::{Program, build_and_run};
use crate::error::Error;
use palpate_tissue::Error as TissueError;
use palpate_tissue::shard::{FILE, Part, complete, program};

/// Campaigns of the evidence.
pub const STUDIES: [&str; 6] = ["accept", "chart", "faults", "faults --paths", "faults --hands", "stability"];

/// Campaigns of `palpate-full`.
#[cfg(not(feature = "full"))]
const OF_FULL: [&str; 1] = ["fit --scenes"];

/// Arguments of `palpate merge`.
#[derive(Args, Clone, Debug)]
pub struct MergeArgs {
    /// Folders of shards (shard-I-of-N), or folders that contain such folders, as given with --out
    /// when the shards ran.
    #[arg(value_name = "FOLDER", required = true)]
    folders: Vec<PathBuf>,
    /// Output folder of the merged result, created if missing; replaces an earlier result in it.
    #[arg(long, value_name = "FOLDER", default_value = "out/merged")]
    pub out: PathBuf,
    /// Print every row, as the campaign's command does with --all.
    #[arg(long)]
    pub all: bool,
}

impl MergeArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let parts = self.parts()?;
        match parts.first().map_or("", |part| part.heading.command.as_str()) {
            study if STUDIES.contains(&study) => return build_and_run(Program::Lab),
            #[cfg(not(feature = "full"))]
            other if OF_FULL.contains(&other) => return build_and_run(Program::Full),
            _ => {}
        }
        let (out, all) = (&self.out, self.all);
        let campaign = Self::campaign(&parts)?.to_owned();
        match campaign.as_str() {
            Loop::COMMAND => Loop::merge(parts, out, all),
            #[cfg(feature = "full")]
            FitScenes::COMMAND => FitScenes::merge(parts, out, all),
            other => Err(Self::unknown(other)),
        }
    }

    /// Every shard of the campaign.
    ///
    /// # Errors
    /// One is missing, duplicate or damaged, or `--out` is the folder of one.
    pub fn parts(&self) -> Result<Vec<Part>, Error> {
        if self.out.join(FILE).exists() {
            return Err(TissueError::Usage(format!(
                "--out {}: it is the folder of a shard, which the whole would replace: choose another folder",
                self.out.display()
            ))
            .into());
        }
        Ok(complete(&self.folders)?)
    }

    /// Name of the campaign, which this program must have run.
    ///
    /// # Errors
    /// Another program ran the shards.
    pub fn campaign(parts: &[Part]) -> Result<&str, Error> {
        let Some(heading) = parts.first().map(|part| &part.heading) else { return Ok("nothing") };
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
        Ok(&heading.command)
    }

    /// The error for a campaign that this program does not know.
    #[must_use]
    pub fn unknown(campaign: &str) -> Error {
        TissueError::Usage(format!("this program knows no shards of {campaign}: merge with the one that ran them")).into()
    }
}
