//! Command line of `palpate suite`.

use std::path::PathBuf;

use clap::Args;

use crate::command::campaign::CaseArgs;

#[derive(Args, Clone, Debug)]
pub struct SuiteArgs {
    #[command(flatten)]
    pub options: SuiteOptions,
    /// Output folder, created if missing; a finished run replaces an earlier result in it.
    #[arg(long, value_name = "FOLDER", default_value = "out/suite")]
    pub out: PathBuf,
    #[command(flatten)]
    pub cases: CaseArgs,
}

/// The settings that determine the rows.
#[derive(Args, Clone, Debug)]
pub struct SuiteOptions {
    /// Only meshes of 130 nodes, instead of 57, 130 and 410.
    #[arg(long)]
    pub quick: bool,
}
