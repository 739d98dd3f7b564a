//! The loop half of `palpate stability`.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::error::Error;
use crate::output::OutputFolder;
use crate::stability::loop_matrix::{LoopSummary, Plan, pictures, print, write};

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
