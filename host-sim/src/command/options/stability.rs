//! Command line of `palpate stability`.

use std::path::PathBuf;

use clap::Args;

use crate::command::campaign::CaseArgs;

#[derive(Args, Clone, Debug)]
pub struct StabilityArgs {
    #[command(flatten)]
    pub options: StabilityOptions,
    /// Output folder, created if missing; a finished run replaces an earlier result in it.
    #[arg(long, value_name = "FOLDER", default_value = "out/stability")]
    pub out: PathBuf,
    #[command(flatten)]
    pub cases: CaseArgs,
}

/// The settings of both matrices.
#[derive(Args, Clone, Debug)]
pub struct StabilityOptions {
    /// Run only the methods, without a device in the loop.
    #[arg(long, conflicts_with = "only_loop")]
    pub model: bool,
    /// Run only the loop, without the methods.
    #[arg(long = "loop")]
    pub only_loop: bool,
    /// Use a smaller mesh, two stiffnesses, five ways to press and one device: 90 s of processor
    /// time.
    #[arg(long)]
    pub quick: bool,
    /// Also run the loop on every shipped device, at its own delay.
    #[arg(long, conflicts_with_all = ["quick", "model"])]
    pub full: bool,
}
