//! A study: numbered cases, rows, claims and figures. [`Runner`] runs its cases at once or in
//! shards, and writes, prints and judges what it finds.

mod findings;
mod table;

use std::fmt::Debug;
use std::ops::Range;
use std::path::Path;

use palpate_sim::command::campaign::{Campaign, Shards};
use palpate_sim::error::Error;
use palpate_tissue::output::OutputFolder;
use serde::Serialize;
use serde::de::DeserializeOwned;

pub use findings::{Claim, Findings};
pub use table::{Cell, Columns, Table};

/// A study whose cases are independent of each other.
pub trait Study: Sized {
    /// Name of the command, as on the command line.
    const ID: &'static str;
    /// Everything that determines the cases.
    type Options: Serialize + DeserializeOwned;
    /// Result of one or several adjacent cases.
    type Row: Serialize + DeserializeOwned + Debug;

    /// Creates the study, and reads the files that the options name.
    ///
    /// # Errors
    /// Fails if the input is invalid.
    fn load(options: Self::Options) -> Result<Self, Error>;

    /// Everything that determines the cases.
    fn options(&self) -> &Self::Options;

    /// Number of cases.
    fn cases(&self) -> u64;

    /// Runs the cases with these numbers.
    ///
    /// # Errors
    /// A case cannot be run.
    fn run(&self, cases: Range<u64>) -> Result<Vec<Self::Row>, Error>;

    /// Tables, claims and figures of the rows of all cases, which are in their order.
    ///
    /// # Errors
    /// A table cannot be formatted, or a further run fails.
    fn findings(&self, rows: Vec<Self::Row>) -> Result<Findings, Error>;
}

/// Runs a study as a campaign.
pub struct Runner<S>(S);

impl<S: Study> Campaign for Runner<S> {
    type Options = S::Options;
    type Counts = Vec<S::Row>;
    const COMMAND: &'static str = S::ID;

    fn load(options: S::Options) -> Result<Self, Error> {
        S::load(options).map(Self)
    }

    fn options(&self) -> &S::Options {
        self.0.options()
    }

    fn cases(&self) -> u64 {
        self.0.cases()
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<S::Row>, Error> {
        self.0.run(cases)
    }

    fn add(rows: &mut Vec<S::Row>, next: Vec<S::Row>) {
        rows.extend(next);
    }

    fn report(&self, folder: OutputFolder, rows: Vec<S::Row>, all: bool) -> Result<(), Error> {
        self.0.findings(rows)?.report(folder, all)
    }
}

/// Runs all cases of a study, or the requested shards.
///
/// # Errors
/// The input is invalid, or a claim does not hold.
pub fn start<S: Study>(options: S::Options, shards: &Shards, out: &Path) -> Result<(), Error> {
    Runner::<S>::start(options, shards, out)
}
