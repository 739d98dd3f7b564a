//! The path campaign: a position-controlled tip on random paths through, along, around and under
//! the tissue, off its edges and into its sides, over every shipped patch, at 1-100 kPa, with the
//! counts, limits and delay of every device.
//!
//! The sensor is honest and no hand yields, so whatever breaks is the loop's own. A [`PathCase`] is
//! drawn from a number: the same number gives the same run.

mod case;
mod ground;
mod route;
mod run;
mod table;

pub use case::{KINDS, PathCase, PathKind};
pub use ground::{PathGround, PathPatch};
pub use route::{Leg, Route};
pub use run::{PathOutcome, Track};
pub use table::{PathRow, PathTable};

use palpate::BuildError;
use rayon::prelude::*;

/// Runs that are handed to a thread at a time.
const BATCH: u64 = 16;

/// Runs `runs` paths of this seed; `done` is called for every batch.
///
/// # Errors
/// The loop or a patch refuses its settings.
pub fn paths(ground: &PathGround, runs: u64, seed: u64, done: impl Fn(u64) + Sync) -> Result<PathTable, BuildError> {
    let batches: Vec<u64> = (0..runs.div_ceil(BATCH)).collect();
    let part = |batch: &u64| {
        let numbers = batch * BATCH..runs.min((batch + 1) * BATCH);
        let mut table = PathTable::default();
        for number in numbers.clone() {
            let case = PathCase::draw(ground, number, seed);
            table.count(ground, &case, &run::run(ground, &case)?);
        }
        done(numbers.end - numbers.start);
        Ok(table)
    };
    let parts: Vec<Result<PathTable, BuildError>> = batches.par_iter().map(part).collect();
    let mut table = PathTable::default();
    for part in parts {
        table.add(&part?);
    }
    Ok(table)
}
