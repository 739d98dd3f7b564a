//! The loop half of `palpate stability`.

use super::progress::Progress;
use crate::error::Error;
use palpate_lab::stability::loop_matrix::{LoopSummary, Scope, draw, print, write};
use palpate_tissue::output::OutputFolder;

/// Measures the loop, writes its tables and pictures, prints the table.
pub(super) fn run_loop(folder: &OutputFolder, quick: bool, full: bool) -> Result<LoopSummary, Error> {
    let scope = Scope::new(quick, full)?;
    let progress = Progress::new(scope.steps() as u64, "loops");
    let summary = LoopSummary::measure(&scope, &|| progress.inc(1));
    progress.finish();
    let summary = summary?;
    write(folder, &summary)?;
    draw(folder, &summary)?;
    print(&summary);
    Ok(summary)
}
