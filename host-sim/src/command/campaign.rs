//! Commands whose work is numbered cases. They run all cases, or ranges of cases whose rows are
//! merged later.
//!
//! ```text
//! --cases 0..50   ─ Campaign::run ─ rows.csv ┐
//! --cases 50..100 ─ Campaign::run ─ rows.csv ┴ palpate merge ─ Campaign::report, as of one run
//! ```
//!
//! Any scheduler can start the ranges: they do not communicate.

pub mod fingerprint;
pub mod rows;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use serde::de::DeserializeOwned;

use self::rows::{FILE, Heading, Part};
use super::stop;
use crate::error::Error;
use crate::provenance;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;

/// Selection of the cases that this process runs, and of the rows that it prints.
#[derive(Args, Clone, Debug, Default)]
pub struct CaseArgs {
    /// Print every row; otherwise only the failed rows and the totals are printed.
    #[arg(long)]
    pub all: bool,
    /// Run only the cases from number A up to B - 1, counted from 0, and write their rows to a
    /// folder of its own below --out, for `palpate merge`. A range whose rows are there already is
    /// not run again.
    #[arg(long, value_name = "A..B", value_parser = range, help_heading = "Many machines")]
    cases: Option<Range<u64>>,
    /// Folders of the rows of all cases, none of which is then run: how `palpate merge` starts the
    /// command.
    #[arg(long, hide = true, value_name = "FOLDER", conflicts_with = "cases")]
    rows_in: Vec<PathBuf>,
}

impl CaseArgs {
    /// Whether a range of cases was asked for.
    pub fn are_some(&self) -> bool {
        self.cases.is_some()
    }
}

fn range(text: &str) -> Result<Range<u64>, String> {
    let numbers = text.split_once("..").and_then(|(first, end)| Some(first.parse().ok()?..end.parse().ok()?));
    let cases = numbers.filter(|cases: &Range<u64>| !cases.is_empty());
    cases.ok_or_else(|| "give A..B with A below B, such as 0..100 for the first hundred cases".to_owned())
}

/// A command whose work is numbered cases.
pub trait Campaign {
    /// Result of one case, or of several adjacent ones. A field that is not finite must be read
    /// from text.
    type Row: Serialize + DeserializeOwned;

    /// Number of cases in the campaign.
    fn cases(&self) -> u64;

    /// Checksums of the inputs that do not ship with the program, by name.
    fn inputs(&self) -> BTreeMap<String, String> {
        BTreeMap::new()
    }

    /// Runs the cases with these numbers, each independently of the others. Each row comes with the
    /// number of its first case.
    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, Self::Row)>, Error>;

    /// Writes and publishes the result of all cases, prints it, and checks it. With `all`, every
    /// row is printed.
    fn report(&self, folder: OutputFolder, rows: Vec<Self::Row>, all: bool) -> Result<(), Error>;

    /// The scene of all cases, if they share one.
    fn scene(&self) -> Option<&Scene> {
        None
    }

    /// Folder of the result of all cases, under `--out`.
    fn whole(&self, out: &Path) -> PathBuf {
        out.to_owned()
    }

    /// Runs all cases, or the requested range; or merges the rows of ranges.
    fn start(&self, args: &CaseArgs, out: &Path) -> Result<(), Error> {
        if let Some(cases) = &args.cases {
            return self.run_range(cases, out);
        }
        if !args.rows_in.is_empty() {
            return self.merge(&rows::complete(&args.rows_in)?, out, args.all);
        }
        stop::says_what_stays(&self.whole(out));
        let folder = OutputFolder::open(&self.whole(out))?.made_by(provenance::of(self.scene()));
        let rows = self.run(0..self.cases())?;
        self.report(folder, rows.into_iter().map(|(_, row)| row).collect(), args.all)
    }

    /// Runs a range of cases and writes their rows; the checks are made by `merge`, on all of them.
    fn run_range(&self, asked: &Range<u64>, out: &Path) -> Result<(), Error> {
        let of = self.cases();
        let cases = asked.start..asked.end.min(of);
        if cases.is_empty() {
            let why = format!("--cases {asked:?}: there are {of} cases: give a range that begins below {of}");
            return Err(TissueError::Usage(why).into());
        }
        let path = out.join(format!("cases-{}-{}", cases.start, cases.end));
        let heading = Heading::new(self.inputs(), of, cases.clone())?;
        if Part::read(&path.join(FILE)).is_ok_and(|part| part.heading == heading) {
            println!("ok: cases {cases:?} of {of} are in {} already", path.display());
            return Ok(());
        }
        stop::says_what_stays(&path);
        let folder = OutputFolder::open(&path)?;
        let rows = self.run(cases.clone())?;
        folder.write(FILE, rows::text(&heading, &rows)?.as_bytes())?;
        let path = folder.publish()?;
        println!("ok: cases {cases:?} of {of}; wrote {}", path.join(FILE).display());
        Ok(())
    }

    /// Writes the same result as a single run of all cases.
    fn merge(&self, parts: &[Part], out: &Path, all: bool) -> Result<(), Error> {
        let Some(heading) = parts.first().map(|part| &part.heading) else { return Ok(()) };
        let refuse = |why: String| Err(TissueError::Usage(why).into());
        let own = fingerprint::program()?;
        if heading.program != own {
            let ran = &heading.program;
            return refuse(format!("the rows are of program {ran}, this is {own}: merge with the program that ran them"));
        }
        if (self.inputs(), self.cases()) != (heading.inputs.clone(), heading.of) {
            return refuse("the input has changed since the cases ran: merge with the same files, or run them again".into());
        }
        let mut processors: Vec<&str> = parts.iter().map(|part| part.heading.processor.as_str()).collect();
        processors.dedup();
        let provenance = provenance::of_cases(&heading.command_line, processors.join("; "), heading.cores, self.scene());
        let folder = OutputFolder::open(out)?.made_by(provenance);
        let rows = parts.iter().map(Part::rows).collect::<Result<Vec<_>, _>>()?;
        self.report(folder, rows.into_iter().flatten().map(|(_, row)| row).collect(), all)
    }
}

#[cfg(test)]
mod tests {
    use super::range;

    #[test]
    fn a_range_has_a_first_case_and_an_end_beyond_it() {
        assert_eq!(range("700..800"), Ok(700..800));
        for text in ["", "7", "7..", "..8", "8..7", "7..7", "7/1000", "7...8", "7..=8", "-1..2", "a..b"] {
            assert!(range(text).is_err(), "{text}");
        }
    }
}
