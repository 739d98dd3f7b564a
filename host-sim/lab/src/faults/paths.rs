//! The path campaign: a position-controlled tip on random paths through, along, around and under
//! the tissue, off its edges and into its sides, over every shipped patch, at 1-100 kPa, with the
//! counts, limits and delay of every device.
//!
//! The sensor is correct and no hand yields, so the loop itself causes any violation. A
//! [`PathCase`] is derived from a number: the same number gives the same run.

mod case;
mod ground;
mod route;
mod run;
mod table;

pub use case::{KINDS, PathCase, PathKind};
pub use ground::{PathGround, PathPatch};
pub use route::{Leg, Route};
pub use run::{PathOutcome, Track};
pub use table::{PatchRow, PathRow, PathTable};

use std::ops::Range;

use palpate::BuildError;
use rayon::prelude::*;

use super::campaign::batches;

/// Number of runs that a thread executes at a time.
const BATCH: u64 = 16;

/// Runs the paths with these numbers and this seed; `done` is called after every batch. The tables
/// of parts of a range, added in order, give the table of the whole range.
pub fn paths(ground: &PathGround, cases: Range<u64>, seed: u64, done: impl Fn(u64) + Sync) -> Result<PathTable, BuildError> {
    let part = |numbers: Range<u64>| {
        let mut table = PathTable::default();
        for number in numbers.clone() {
            let case = PathCase::draw(ground, number, seed);
            table.count(ground, &case, &run::run(ground, &case)?);
        }
        done(numbers.end - numbers.start);
        Ok(table)
    };
    batches(cases, BATCH).map(part).try_reduce(PathTable::default, |mut table, more| {
        table.add(&more);
        Ok(table)
    })
}
