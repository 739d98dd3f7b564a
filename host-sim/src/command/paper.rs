//! The command `palpate paper`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::progress::Status;
use crate::error::Error;
use crate::provenance;
use palpate_lab::paper::{Progress, local_compression, volume_preserved};

#[derive(Clone, Debug, Subcommand)]
pub(super) enum PaperCommand {
    /// Paper 000: a liver with its gallbladder on a thread. Table 1, Fig. 2, Fig. 3, section 3.4,
    /// and the cases in which its formulas fail.
    ///
    /// Writes report.md, summary.json, tables as CSV and pictures as SVG and PNG. Fails with exit
    /// code 1 if the product's own promise at full resolution does not hold: landmarks within 1 mm
    /// and 2 mm of finite elements.
    VolumePreserved(PaperArgs),
    /// Paper 004: a finger presses an abdomen and a foot. Figs. 5 to 9, and the cases in which its
    /// formulas fail.
    ///
    /// Writes report.md, summary.json, every curve as CSV and pictures as SVG and PNG. The
    /// annealing saves its state at intervals: if it is stopped, the same command continues it.
    LocalCompression(LocalCompressionArgs),
}

#[derive(Args, Clone, Debug)]
pub(super) struct LocalCompressionArgs {
    /// One scene, abdomen-press or foot-press, or the path of a file like
    /// host-sim/scenes/abdomen-press.toml [default: both].
    #[arg(long, value_name = "NAME|FILE")]
    scene: Option<String>,
    /// Use few forces, few trials at each temperature and coarse organs: 25 s of processor time,
    /// instead of some minutes.
    #[arg(long)]
    quick: bool,
    /// Output folder, created if missing; a finished run replaces an earlier result in it [default:
    /// out/paper-local-compression].
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

#[derive(Args, Clone, Debug)]
pub(super) struct PaperArgs {
    /// The preset, or the path of a scene file like host-sim/scenes/hanging-liver.toml.
    #[arg(long, value_name = "NAME|FILE", default_value = volume_preserved::scene::PRESET)]
    scene: String,
    /// Use only the sparse resolution: 25 s of processor time, instead of some minutes.
    #[arg(long)]
    quick: bool,
    /// Solve the finite elements of the full resolution again instead of using the shipped answer:
    /// some 15 minutes more.
    #[arg(long)]
    solve: bool,
    /// Output folder, created if missing; a finished run replaces an earlier result in it [default:
    /// out/paper-NAME].
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

impl PaperCommand {
    pub(super) fn run(&self) -> Result<(), Error> {
        match self {
            Self::VolumePreserved(args) => {
                let (scene, quick, solve) = (args.scene.clone(), args.quick, args.solve);
                let options = volume_preserved::Options { scene, quick, solve, provenance: provenance::of(None) };
                let folder = folder(args.out.as_ref(), "volume-preserved");
                Ok(volume_preserved::run(&options, &folder, &Status::start())?)
            }
            Self::LocalCompression(args) => {
                let (scene, quick) = (args.scene.clone(), args.quick);
                let options = local_compression::Options { quick, scene, provenance: provenance::of(None) };
                let folder = folder(args.out.as_ref(), "local-compression");
                Ok(local_compression::run(&options, &folder, &Status::start())?)
            }
        }
    }
}

impl Progress for Status {
    fn say(&self, doing: String) {
        Self::say(self, doing);
    }

    fn clear(&self) {
        Self::clear(self);
    }
}

fn folder(out: Option<&PathBuf>, paper: &str) -> PathBuf {
    out.cloned().unwrap_or_else(|| PathBuf::from("out").join(format!("paper-{paper}")))
}
