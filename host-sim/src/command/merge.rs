//! The command `palpate merge`: starts the command whose cases ran in ranges once more, with their
//! rows.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, Parser};

use super::Cli;
use super::campaign::rows::{FILE, complete};
use crate::error::Error;
use palpate_tissue::Error as TissueError;

/// Arguments of `palpate merge`.
#[derive(Args, Clone, Debug)]
pub struct MergeArgs {
    /// Folders of ranges (cases-A-B), or folders that contain such folders, as given with --out
    /// when the cases ran.
    #[arg(value_name = "FOLDER", required = true)]
    folders: Vec<PathBuf>,
    /// Output folder of the merged result, created if missing; replaces an earlier result in it.
    #[arg(long, value_name = "FOLDER", default_value = "out/merged")]
    pub out: PathBuf,
    /// Print every row, as the campaign's command does with --all.
    #[arg(long)]
    pub all: bool,
}

impl MergeArgs {
    /// The command that reports the rows of all cases.
    pub(super) fn command(&self) -> Result<Cli, Error> {
        if self.out.join(FILE).exists() {
            let out = self.out.display();
            let why = format!("--out {out}: it has rows, which the result would replace: choose another folder");
            return Err(TissueError::Usage(why).into());
        }
        let parts = complete(&self.folders)?;
        let Some(heading) = parts.first().map(|part| &part.heading) else {
            return Err(TissueError::Usage("there are no rows to merge: give their folders".into()).into());
        };
        let mut words: Vec<OsString> =
            std::iter::once("palpate").chain(heading.command_line.iter().map(String::as_str)).map(OsString::from).collect();
        words.extend(["--out".into(), self.out.clone().into()]);
        words.extend(self.all.then(|| "--all".into()));
        self.folders.iter().for_each(|folder| words.extend(["--rows-in".into(), folder.clone().into()]));
        Cli::try_parse_from(words).map_err(|_| {
            let (line, version) = (heading.command_line.join(" "), &heading.version);
            TissueError::Usage(format!(
                "the rows are of `palpate {line}` of version {version}, not of this one: merge with that one"
            ))
            .into()
        })
    }
}
