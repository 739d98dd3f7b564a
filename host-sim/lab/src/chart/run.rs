//! One row of the chart.

use super::accuracy::Accuracy;
use super::cycles::m4f_cycles;
use super::plan::Task;
use super::reference::Reference;
use super::survive::{Failure, Trial, least_substeps};
use super::timing::{TickTime, tick_time};
use crate::error::Error;
use crate::rivals::{Block, Size};

/// Row of the chart: its task, the counts of its mesh and its outcome.
#[derive(Clone, Debug)]
pub struct Run {
    /// Task that was run.
    pub task: Task,
    /// Counts of its mesh.
    pub size: Size,
    /// Measured values; otherwise the reason why there are none.
    pub outcome: Result<Measured, String>,
}

/// Measured values of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Substeps of a tick.
    pub substeps: u16,
    /// The deepest press.
    pub trial: Trial,
    /// Errors.
    pub accuracy: Accuracy,
    /// Time of a tick.
    pub time: TickTime,
    /// Estimated cycles of a tick on a Cortex-M4F.
    pub m4f_cycles: f64,
}

impl Run {
    /// Returns the measured values if the method survived the deepest press.
    #[must_use]
    pub fn survived(&self) -> Option<&Measured> {
        self.outcome.as_ref().ok().filter(|m| m.trial.failure.is_none())
    }

    /// "yes", or how it failed.
    #[must_use]
    pub fn verdict(&self) -> String {
        match &self.outcome {
            Err(why) => why.clone(),
            Ok(m) => m.trial.failure.map_or("yes".into(), |f| f.to_string()),
        }
    }
}

/// Runs a row. `None` where the method cannot be had.
///
/// # Errors
/// A method that cannot be built.
pub fn measure(task: Task, block: &Block, reference: &Reference) -> Result<Option<Run>, Error> {
    let size = block.size();
    let run = |outcome| Ok(Some(Run { task, size, outcome }));
    let survival = match least_substeps(task.method, block)? {
        None => return Ok(None),
        Some(Err(failure)) => return run(Err(format!("{failure} with up to {} substeps", super::MOST_SUBSTEPS))),
        Some(Ok(survival)) => survival,
    };
    let substeps = survival.substeps;
    let accuracy = task.method.run(block, substeps, |rival| Accuracy::measure(block, rival, reference))?;
    let time = tick_time(task.method, block, substeps)?;
    match (accuracy, time) {
        (Some(Ok(accuracy)), Some(Ok(time))) => run(Ok(Measured {
            substeps,
            trial: survival.trial,
            accuracy,
            time,
            m4f_cycles: m4f_cycles(task.method, block, substeps, time.solver_flops).unwrap_or(f64::NAN),
        })),
        _ => run(Err(format!("{} when pressed from hold to hold with {substeps} substeps", Failure::Diverged { depth_mm: 8.0 }))),
    }
}
