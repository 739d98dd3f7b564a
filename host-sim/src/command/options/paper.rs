//! Command line of `palpate paper`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

#[derive(Clone, Debug, Subcommand)]
pub enum PaperCommand {
    /// Paper 000: a liver with its gallbladder on a thread. Table 1, Fig. 2, Fig. 3 and section
    /// 3.4.
    ///
    /// Writes report.md, summary.json, tables as CSV and pictures as SVG and PNG. Fails with exit
    /// code 1 if the product's own promise at full resolution does not hold: landmarks within 1 mm
    /// and 2 mm of finite elements.
    VolumePreserved(PaperArgs),
    /// Paper 004: a finger presses an abdomen and a foot. Figs. 5 to 9.
    ///
    /// Writes report.md, summary.json, every curve as CSV and pictures as SVG and PNG. The
    /// annealing saves its state at intervals: if it is stopped, the same command continues it.
    LocalCompression(LocalCompressionArgs),
}

#[derive(Args, Clone, Debug)]
pub struct LocalCompressionArgs {
    /// One of the two scenes [default: both].
    #[arg(long, value_name = "NAME", value_parser = ["abdomen-press", "foot-press"])]
    pub scene: Option<String>,
    /// Use few forces, few trials at each temperature and coarse organs: 25 s of processor time,
    /// instead of some minutes.
    #[arg(long)]
    pub quick: bool,
    /// Output folder, created if missing; a finished run replaces an earlier result in it [default:
    /// out/paper-local-compression].
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}

#[derive(Args, Clone, Debug)]
pub struct PaperArgs {
    /// The preset, or the path of a scene file like host-sim/scenes/hanging-liver.toml.
    #[arg(long, value_name = "NAME|FILE", default_value = "hanging-liver")]
    pub scene: String,
    /// Use only the sparse resolution: 25 s of processor time, instead of some minutes.
    #[arg(long)]
    pub quick: bool,
    /// Solve the finite elements of the full resolution again instead of using the shipped answer:
    /// some 15 minutes more.
    #[arg(long)]
    pub solve: bool,
    /// Output folder, created if missing; a finished run replaces an earlier result in it [default:
    /// out/paper-NAME].
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}
