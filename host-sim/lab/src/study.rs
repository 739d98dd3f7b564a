//! A study: numbered cases, rows, claims and figures. [`start`] runs its cases at once or in
//! ranges, and writes, prints and judges what it finds.

mod findings;
pub mod number;
mod table;

use std::ops::Range;
use std::path::Path;

use palpate_sim::command::campaign::{Campaign, CaseArgs};
use palpate_sim::error::Error;
use palpate_tissue::output::OutputFolder;
use serde::Serialize;
use serde::de::DeserializeOwned;

pub use findings::{Claim, Findings};
pub use table::{Cell, Columns, Table};

/// A study whose cases are independent of each other.
pub trait Study {
    /// Result of one or several adjacent cases, all of whose numbers are finite unless they are
    /// written with [`number`].
    type Row: Serialize + DeserializeOwned;

    /// Number of cases.
    fn cases(&self) -> u64;

    /// Runs the cases with these numbers. Each row comes with the number of its first case.
    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, Self::Row)>, Error>;

    /// Tables, claims and figures of the rows of all cases, which are in their order.
    fn findings(&self, rows: Vec<Self::Row>) -> Result<Findings, Error>;
}

/// A study as a campaign.
struct Runner<S>(S);

impl<S: Study> Campaign for Runner<S> {
    type Row = S::Row;

    fn cases(&self) -> u64 {
        self.0.cases()
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, S::Row)>, Error> {
        self.0.run(cases)
    }

    fn report(&self, folder: OutputFolder, rows: Vec<S::Row>, all: bool) -> Result<(), Error> {
        self.0.findings(rows)?.report(folder, all)
    }
}

/// Runs all cases of a study, or the requested range; or merges the rows of ranges.
pub fn start(study: impl Study, args: &CaseArgs, out: &Path) -> Result<(), Error> {
    Runner(study).start(args, out)
}
