//! Measurement of one row of the chart.

use super::accuracy::Accuracy;
use crate::study::number;
use serde::{Deserialize, Serialize};

use super::cycles::m4f_cycles;
use super::moving::Moving;
use super::reference::Reference;
use super::scope::Task;
use super::survive::{Failure, PressResult, Survival, least_substeps, try_press};
use super::timing::{TickTime, tick_time};
use crate::error::Error;
use crate::methods::{Block, Method, Size};

/// Row of the chart: its task, the counts of its mesh and its outcome.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Run {
    /// Task that was run.
    pub task: Task,
    /// Numbers of nodes, edges and tets of the mesh.
    pub size: Size,
    /// Measured values, or the reason why there are none.
    pub outcome: Result<Measured, String>,
}

/// Measured values of a row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Substeps per tick.
    pub substeps: u16,
    /// Outcome of the deepest press.
    pub trial: PressResult,
    /// Errors at rest.
    pub accuracy: Accuracy,
    /// Errors while the probe moves; `None` if they were not requested, no reference exists, or the
    /// method diverges in a ramp or the tap.
    pub moving: Option<Moving>,
    /// Processor time of a tick.
    pub time: TickTime,
    /// Estimated cycles of a tick on a Cortex-M4F.
    #[serde(with = "number")]
    pub m4f_cycles: f64,
}

impl Measured {
    /// Root mean square error while the probe moves [%]; `None` if it was not measured or the
    /// method diverged.
    pub fn moving_rms_pct(&self) -> Option<f64> {
        self.moving.map(|moving| moving.rms_pct())
    }
}

impl Run {
    /// Returns the measured values if the method survived the deepest press.
    pub fn survived(&self) -> Option<&Measured> {
        self.outcome.as_ref().ok().filter(|m| m.trial.failure.is_none())
    }

    /// "yes" if the method survived the deepest press, else the way in which it failed.
    pub fn verdict(&self) -> String {
        match &self.outcome {
            Err(why) => why.clone(),
            Ok(m) => m.trial.failure.map_or("yes".into(), |f| f.to_string()),
        }
    }
}

/// Runs the rows of one method, mesh and stiffness, which differ only in their refinement; returns
/// none of them if the method is not available.
pub fn measure(tasks: &[Task], block: &Block, reference: &Reference, moving: bool) -> Result<Vec<Run>, Error> {
    let Some(first) = tasks.first() else { return Ok(Vec::new()) };
    let survival = least_substeps(first.method, block)?;
    let mut runs = Vec::new();
    for &task in tasks {
        let block = block.clone().refined(task.refinement);
        let outcome = match survival {
            None => return Ok(Vec::new()),
            Some(Err(failure)) => Some(Err(format!("{failure} with up to {} substeps", super::MOST_SUBSTEPS))),
            Some(Ok(survival)) => of_task(task, &block, reference, survival, moving)?,
        };
        // a law has none of the mesh's items
        let none = Size { nodes: 0, edges: 0, tets: 0 };
        let size = if task.method == Method::Law { none } else { block.size() };
        runs.extend(outcome.map(|outcome| Run { task, size, outcome }));
    }
    Ok(runs)
}

/// Measures one row, starting from the number of substeps that survives without refinement.
fn of_task(
    task: Task,
    block: &Block,
    reference: &Reference,
    survival: Survival,
    moving: bool,
) -> Result<Option<Result<Measured, String>>, Error> {
    let substeps = survival.substeps;
    let trial = match task.refinement {
        1 => Some(survival.trial),
        _ => task.method.run(block, substeps, |running| try_press(block, running))?,
    };
    let Some(trial) = trial else { return Ok(None) };
    let moving = if moving { Moving::measure(task.method, block, substeps)?.and_then(Result::ok) } else { None };
    let accuracy = task.method.run(block, substeps, |running| Accuracy::measure(block, running, reference))?;
    let time = tick_time(task.method, block, substeps)?;
    let all = substeps.saturating_mul(task.refinement);
    Ok(Some(match (accuracy, time) {
        (Some(Ok(accuracy)), Some(Ok(time))) => Ok(Measured {
            substeps: all,
            trial,
            accuracy,
            moving,
            time,
            m4f_cycles: m4f_cycles(task.method, block, all, time.solver_flops).unwrap_or(f64::NAN),
        }),
        _ => Err(format!("{} when pressed from hold to hold with {all} substeps", Failure::Diverged { depth_mm: 8.0 })),
    }))
}
