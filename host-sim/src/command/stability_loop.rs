//! The loop half of `palpate stability`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::error::Error;
use crate::output::OutputFolder;
use crate::stability::loop_matrix::{LoopSummary, Plan, pictures, print, write};

#[derive(Args, Clone, Debug)]
pub(super) struct StabilityLoopArgs {
    /// The Touch alone, and every other tissue: under a minute.
    #[arg(long, conflicts_with = "full")]
    quick: bool,
    /// Every shipped device too, at its own delay.
    #[arg(long)]
    full: bool,
    /// Output folder, made if it is not there.
    #[arg(long, value_name = "FOLDER", default_value = "out/stability-loop")]
    out: PathBuf,
}

impl StabilityLoopArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let folder = OutputFolder::open(&self.out)?;
        let summary = run_loop(&folder, self.quick, self.full)?;
        folder.write_json("summary.json", &summary)?;
        println!("\nwrote {}: summary.json, stability_loop.csv, ceilings.csv, pictures as SVG and PNG", folder.path().display());
        summary.check()
    }
}

/// Measures the loop, writes its tables and pictures, prints the table.
pub(super) fn run_loop(folder: &OutputFolder, quick: bool, full: bool) -> Result<LoopSummary, Error> {
    let plan = Plan::new(quick, full)?;
    let bar = ProgressBar::with_draw_target(Some(plan.steps() as u64), ProgressDrawTarget::stderr());
    bar.set_style(
        ProgressStyle::with_template("{bar:30} {pos}/{len} loops {elapsed}").unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    bar.enable_steady_tick(Duration::from_millis(500));
    let summary = LoopSummary::measure(&plan, &|| bar.inc(1));
    bar.finish_and_clear();
    let summary = summary?;
    write(folder, &summary)?;
    pictures(folder, &summary)?;
    print(&summary);
    Ok(summary)
}
