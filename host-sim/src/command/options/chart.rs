//! Command line of `palpate chart`.

use std::path::PathBuf;

use clap::Args;

use crate::command::campaign::CaseArgs;

#[derive(Args, Clone, Debug)]
pub struct ChartArgs {
    #[command(flatten)]
    pub options: ChartOptions,
    /// Only write press.json, which describes the press for other engines; see host-sim/lab/peers.
    #[arg(long, conflicts_with_all = ["quick", "moving", "kpa", "nodes", "with", "cases"])]
    pub press: bool,
    /// Output folder, created if missing; a finished run replaces an earlier result in it.
    #[arg(long, value_name = "FOLDER", default_value = "out/chart")]
    pub out: PathBuf,
    #[command(flatten)]
    pub cases: CaseArgs,
}

/// The settings that determine the rows.
#[derive(Args, Clone, Debug)]
pub struct ChartOptions {
    /// Only the two smallest meshes at 3.5 kPa: 5 s of processor time.
    #[arg(long)]
    pub quick: bool,
    /// Also measure the force while the probe moves, against finite elements with true masses, and
    /// try shorter substeps: three times the rows, and 100 kPa as well.
    #[arg(long)]
    pub moving: bool,
    /// Measure only this one of the chart's Young's moduli [kPa].
    #[arg(long, value_name = "KPA")]
    pub kpa: Option<f64>,
    /// Measure only these of the chart's numbers of nodes.
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub nodes: Vec<usize>,
    /// Also draw and compare the results of other engines at this press: the peers.csv that
    /// host-sim/lab/peers/run.py wrote.
    #[arg(long, value_name = "FILE", conflicts_with = "cases")]
    pub with: Option<PathBuf>,
}
