//! Command line of `palpate unseen`.

use std::path::PathBuf;

use clap::Args;

use crate::command::campaign::CaseArgs;

#[derive(Args, Clone, Debug)]
pub struct UnseenArgs {
    #[command(flatten)]
    pub options: UnseenOptions,
    /// Output folder, created if missing; a finished run replaces an earlier result in it.
    #[arg(long, value_name = "FOLDER", default_value = "out/unseen")]
    pub out: PathBuf,
    #[command(flatten)]
    pub cases: CaseArgs,
}

/// The scenes that are drawn.
#[derive(Args, Clone, Debug)]
pub struct UnseenOptions {
    /// Number of scenes: 60 if not given, one with --quick.
    #[arg(long, value_name = "NUMBER")]
    pub scenes: Option<u64>,
    /// Seed of the scenes: another seed draws other bodies, sites, tips, depths and Poisson's
    /// ratios.
    #[arg(long, value_name = "NUMBER", default_value_t = 2026)]
    pub seed: u64,
    /// Fewer presses and rounds of the fit: 60 s of processor time for a scene.
    #[arg(long)]
    pub quick: bool,
}
