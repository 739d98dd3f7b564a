//! Saves an annealing walk at intervals, so that an interrupted run can continue from there.

use serde::{Deserialize, Serialize};

use super::fit::Step;
use super::schedule::Walk;
use crate::error::Error;
use palpate_tissue::output::OutputFolder;

/// Contents of a checkpoint file.
#[derive(Deserialize, Serialize)]
struct Checkpoint {
    /// Description of the fit, so that a different fit does not continue its walk.
    of: String,
    walk: Walk,
    steps: Vec<[f64; 4]>,
}

/// Reads the saved walk of the same fit; `None` if there is none or it cannot be read, so that the
/// walk starts again.
pub fn read(folder: &OutputFolder, name: &str, of: &str, fresh: &Walk) -> Option<(Walk, Vec<Step>)> {
    let text = folder.read_note(name)?;
    let found: Checkpoint = serde_json::from_str(&text).ok()?;
    let steps = found.steps.iter().map(|[temperature_mm, k, d, distance_mm]| Step {
        temperature_mm: *temperature_mm,
        stiffness_n_per_m: *k,
        damping_n_s_per_m: *d,
        distance_mm: *distance_mm,
    });
    (found.of == of && found.walk.is_same(fresh)).then(|| (found.walk, steps.collect()))
}

/// Writes a walk and its record.
pub fn write(folder: &OutputFolder, name: &str, of: &str, walk: &Walk, steps: &[Step]) -> Result<(), Error> {
    let steps = steps.iter().map(|s| [s.temperature_mm, s.stiffness_n_per_m, s.damping_n_s_per_m, s.distance_mm]).collect();
    Ok(folder.write_note(name, &Checkpoint { of: of.into(), walk: walk.clone(), steps })?)
}
