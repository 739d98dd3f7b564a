//! Commands whose work is numbered cases. They run all cases at once, or shards that are merged
//! later.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::Error;
use crate::provenance;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;
use palpate_tissue::shard::{FILE, Heading, Part, PartError, Shard};

/// Selection of the cases that this process runs, and of the rows that it prints.
#[derive(Args, Clone, Debug, Default)]
pub struct Shards {
    /// Print every row; otherwise only the failed rows and the totals are printed.
    #[arg(long)]
    pub all: bool,
    /// Run only part I of N of the cases, and write its counts to a folder of its own below --out,
    /// for `palpate merge`. May be given several times.
    #[arg(long, value_name = "I/N", help_heading = "Many machines")]
    shard: Vec<Shard>,
}

impl Shards {
    /// Whether shards were asked for.
    #[must_use]
    pub fn any(&self) -> bool {
        !self.shard.is_empty()
    }
}

/// A command whose work is numbered cases.
pub trait Campaign: Sized {
    /// Everything that determines the campaign's cases.
    type Options: Serialize + DeserializeOwned;
    /// Counts over some of the cases.
    type Counts: Serialize + DeserializeOwned + Debug;
    /// Name of the command, as on the command line.
    const COMMAND: &'static str;

    /// Creates the campaign, and reads the files that the options name.
    ///
    /// # Errors
    /// Fails if the input is invalid.
    fn load(options: Self::Options) -> Result<Self, Error>;

    /// Creates the campaign of shards that ran elsewhere.
    ///
    /// # Errors
    /// Its input is missing or has changed.
    fn of_shards(options: Self::Options, heading: &Heading) -> Result<Self, Error> {
        let campaign = Self::load(options)?;
        if campaign.inputs() == heading.inputs && campaign.cases() == heading.cases {
            return Ok(campaign);
        }
        Err(TissueError::Usage(format!(
            "the input of `palpate {}` is no longer that of the shards: merge where they ran, with the same files, or run them again",
            Self::COMMAND
        ))
        .into())
    }

    /// Everything that determines the campaign's cases.
    fn options(&self) -> &Self::Options;

    /// Number of cases in the campaign.
    fn cases(&self) -> u64;

    /// Checksums of the inputs that do not ship with the program, by name.
    fn inputs(&self) -> BTreeMap<String, String> {
        BTreeMap::new()
    }

    /// Runs the cases with these numbers, each independently of the others.
    fn run(&self, cases: Range<u64>) -> Result<Self::Counts, Error>;

    /// Adds the counts of the cases that follow. The sum is exact: no rounded numbers are added.
    fn add(counts: &mut Self::Counts, next: Self::Counts);

    /// Writes and publishes the result of all cases, prints it, and checks it. With `all`, every
    /// row is printed.
    fn report(&self, folder: OutputFolder, counts: Self::Counts, all: bool) -> Result<(), Error>;

    /// The scene of all cases, if they share one.
    fn scene(&self) -> Option<&Scene> {
        None
    }

    /// Folder of the result of all cases, under `--out`.
    fn whole(out: &Path) -> PathBuf {
        out.to_owned()
    }

    /// Runs all cases, or the requested shards.
    fn start(options: Self::Options, shards: &Shards, out: &Path) -> Result<(), Error> {
        let campaign = Self::load(options)?;
        if !shards.any() {
            let folder = OutputFolder::open(&Self::whole(out))?.made_by(provenance::of(campaign.scene()));
            let counts = campaign.run(0..campaign.cases())?;
            return campaign.report(folder, counts, shards.all);
        }
        shards.shard.iter().try_for_each(|shard| campaign.run_shard(*shard, out))
    }

    /// Runs a shard and writes its counts; the checks are made by `merge`, on all of them.
    fn run_shard(&self, shard: Shard, out: &Path) -> Result<(), Error> {
        let (total, cases) = (self.cases(), shard.cases(self.cases()));
        let folder = OutputFolder::open(&out.join(format!("shard-{}-of-{}", shard.number(), shard.of())))?;
        let mut heading = Heading::new(Self::COMMAND, self.named_options()?, self.inputs(), total, shard)
            .map_err(|source| TissueError::Read { path: "the program's own file".into(), source })?;
        heading.command_line = provenance::command_line();
        let counts = self.run(cases.clone())?;
        folder.write(FILE, Part::write(&heading, &counts).map_err(unwritable)?.as_bytes())?;
        let again: Self::Counts = Part::read(&folder.draft().join(FILE)).map_err(unreadable)?.counts().map_err(unwritable)?;
        // JSON cannot represent every number: an error here is better than a wrong result after the
        // merge
        if format!("{again:?}") != format!("{counts:?}") {
            return Err(unreadable(PartError::Damaged));
        }
        let file = folder.publish()?.join(FILE);
        println!("ok: shard {shard} has cases {} up to {} of {total}; wrote {}", cases.start, cases.end, file.display());
        Ok(())
    }

    /// The options by their names.
    ///
    /// # Errors
    /// JSON cannot represent them.
    fn named_options(&self) -> Result<BTreeMap<String, serde_json::Value>, Error> {
        let value = serde_json::to_value(self.options()).map_err(unwritable)?;
        Ok(value.as_object().into_iter().flatten().map(|(key, value)| (key.clone(), value.clone())).collect())
    }

    /// Writes the same result as a single run of all cases.
    fn merge(parts: Vec<Part>, out: &Path, all: bool) -> Result<(), Error> {
        let Some(heading) = parts.first().map(|part| part.heading.clone()) else { return Ok(()) };
        let unread = |shard: Shard| {
            move |why| TissueError::Usage(format!("shard {shard} of {} cannot be read: {why}: run it again", Self::COMMAND))
        };
        let options = serde_json::from_value(heading.options.clone().into_iter().collect()).map_err(unread(heading.shard))?;
        let campaign = Self::of_shards(options, &heading)?;
        let folder = OutputFolder::open(out)?.made_by(provenance::of_shards(&parts, campaign.scene()));
        let mut counts: Option<Self::Counts> = None;
        for part in parts {
            let next = part.counts().map_err(unread(part.heading.shard))?;
            match &mut counts {
                Some(counts) => Self::add(counts, next),
                None => counts = Some(next),
            }
        }
        counts.map_or(Ok(()), |counts| campaign.report(folder, counts, all))
    }
}

fn unreadable(why: PartError) -> Error {
    TissueError::Write { path: PathBuf::from(FILE), source: std::io::Error::other(why) }.into()
}

fn unwritable(why: serde_json::Error) -> Error {
    TissueError::Write { path: PathBuf::from(FILE), source: why.into() }.into()
}
