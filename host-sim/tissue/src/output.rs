//! Output folder of a run: a result appears complete, in place of an earlier one, or not at all.
//!
//! A run writes into a draft beside the folder and moves it into place at the end. An error, a kill
//! or a full disk before that leaves the earlier result as it was. For `--out out/press`:
//!
//! ```text
//! out/press           the last result that was finished
//! out/.press.lock     held while a run writes; a second run is refused
//! out/.press.draft    the result being written; after the exchange, for a moment, the earlier one
//! out/.press.old      the earlier result, for a moment, where two folders cannot be exchanged
//! out/.press.notes    where a stopped run resumes
//! ```
//!
//! The next run that takes the lock removes the remains of a killed one.

mod lock;
mod place;
mod record;

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::error::Error;
use lock::Lock;
use place::Place;
use record::Record;

/// Name of the file with the numbers of a result.
pub const SUMMARY: &str = "summary.json";

/// Suffix that the record of a fit adds to the name of its patch file.
pub const RECORD_SUFFIX: &str = ".json";

/// A summary with its provenance.
#[derive(serde::Serialize)]
struct Signed<'a, T> {
    #[serde(flatten)]
    summary: &'a T,
    #[serde(skip_serializing_if = "Option::is_none")]
    provenance: Option<&'a serde_json::Value>,
}

/// Way in which a result enters its folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    /// The whole folder is replaced.
    Replace,
    /// Each file is a result of its own and is added.
    Add,
}

/// A result that is being written.
#[derive(Debug)]
pub struct OutputFolder {
    /// Path as given on the command line.
    shown: PathBuf,
    place: Place,
    mode: Mode,
    /// Patches of an earlier run that this one replaces.
    dropped: Vec<String>,
    /// Provenance of this run, for its summary.
    provenance: Option<serde_json::Value>,
    // declared last, so that it is released last
    _lock: Lock,
}

impl OutputFolder {
    /// Locks the folder, cleans up after a killed run, and begins an empty draft. [`Self::publish`]
    /// replaces the earlier result. Patch files of earlier runs are kept, and so are files that
    /// palpate did not write.
    ///
    /// # Errors
    /// The folder cannot be written, is in use, or has files but no result of palpate.
    pub fn open(path: &Path) -> Result<Self, Error> {
        Self::begin(path, Mode::Replace)
    }

    /// Opens a folder as [`Self::open`] does, but adds the files of this run to those in the
    /// folder: for commands whose files are each a result of their own, such as patches.
    ///
    /// # Errors
    /// The folder cannot be written or is in use.
    pub fn add_to(path: &Path) -> Result<Self, Error> {
        Self::begin(path, Mode::Add)
    }

    fn begin(path: &Path, mode: Mode) -> Result<Self, Error> {
        let refuse = |source| Error::Write { path: path.into(), source };
        let (place, made) = Place::of(path).map_err(refuse)?;
        let Some(lock) = Lock::take(place.lock(), made).map_err(refuse)? else {
            return Err(Error::InUse { path: path.into() });
        };
        let folder = Self { shown: path.into(), place, mode, dropped: Vec::new(), provenance: None, _lock: lock };
        folder.place.recover().map_err(refuse)?;
        if mode == Mode::Replace {
            folder.place.refuse_foreign(path)?;
        }
        if folder.place.folder().exists() {
            // a result in a folder that was deliberately made read-only stays
            tempfile::tempfile_in(folder.place.folder()).map_err(refuse)?;
        }
        std::fs::create_dir(folder.place.draft()).map_err(refuse)?;
        Ok(folder)
    }

    /// Stores the provenance of this run, which every summary then contains.
    #[must_use]
    pub fn made_by(mut self, provenance: serde_json::Value) -> Self {
        self.provenance = Some(provenance);
        self
    }

    /// The folder in which this run's files are written until they are published.
    #[must_use]
    pub fn draft(&self) -> &Path {
        self.place.draft()
    }

    /// Moves the result into place; returns the path of the folder as given on the command line.
    ///
    /// # Errors
    /// The disk is full, or the folder changed during the run. The earlier result is then still
    /// there.
    pub fn publish(self) -> Result<PathBuf, Error> {
        let refuse = |source| Error::Write { path: self.shown.clone(), source };
        match self.mode {
            Mode::Replace => {
                self.place.refuse_foreign(&self.shown)?;
                self.place.replace(&self.dropped).map_err(refuse)?;
            }
            Mode::Add => self.place.add().map_err(refuse)?,
        }
        // a note that remains would be read only by a run that repeats this one
        let _ = std::fs::remove_dir_all(self.place.notes());
        Ok(self.shown.clone())
    }

    /// Marks a patch of an earlier run for removal with the rest of the earlier result.
    pub fn drop_earlier(&mut self, name: &str) {
        self.dropped.push(name.to_owned());
    }

    /// Writes a file of the result.
    ///
    /// # Errors
    /// The disk is full, or the draft has been removed.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Error> {
        std::fs::write(self.draft().join(name), bytes).map_err(|source| Error::Write { path: self.shown.join(name), source })
    }

    /// Writes a note from which a later run can resume if this one is stopped. It is written
    /// completely or not at all, and is not part of the result.
    ///
    /// # Errors
    /// The disk is full.
    pub fn write_note(&self, name: &str, note: &impl serde::Serialize) -> Result<(), Error> {
        let notes = self.place.notes();
        let refuse = |source| Error::Write { path: notes.join(name), source };
        std::fs::create_dir_all(&notes).map_err(refuse)?;
        let mut file = tempfile::NamedTempFile::new_in(&notes).map_err(refuse)?;
        file.write_all(json(name, note)?.as_bytes()).map_err(refuse)?;
        file.persist(notes.join(name)).map_err(|e| refuse(e.error))?;
        Ok(())
    }

    /// Reads the note that a stopped run left, if there is one.
    #[must_use]
    pub fn read_note(&self, name: &str) -> Option<String> {
        std::fs::read_to_string(self.place.notes().join(name)).ok()
    }

    /// Writes a value as JSON.
    ///
    /// # Errors
    /// Errors of [`Self::write`].
    pub fn write_json(&self, name: &str, value: &impl serde::Serialize) -> Result<(), Error> {
        self.write(name, json(name, value)?.as_bytes())
    }

    /// Writes `summary.json`: the fields of `summary`, and `provenance`, which says how they were
    /// made.
    ///
    /// # Errors
    /// Errors of [`Self::write`].
    pub fn write_summary(&self, summary: &impl serde::Serialize) -> Result<(), Error> {
        self.write_json(SUMMARY, &Signed { summary, provenance: self.provenance.as_ref() })
    }

    /// Writes rows as CSV under a header.
    ///
    /// # Errors
    /// Errors of [`Self::write`].
    pub fn write_csv<const COLUMNS: usize>(
        &self,
        name: &str,
        header: [&str; COLUMNS],
        rows: impl IntoIterator<Item = [f64; COLUMNS]>,
    ) -> Result<(), Error> {
        // each number is the shortest decimal that reads back as the same number
        self.write_table(name, header, rows.into_iter().map(|row| row.map(|v| v.to_string())))
    }

    /// Writes rows of cells as CSV under a header; no cell may contain a comma, a quote or a line
    /// end.
    ///
    /// # Errors
    /// Errors of [`Self::write`].
    pub fn write_table<const COLUMNS: usize>(
        &self,
        name: &str,
        header: [&str; COLUMNS],
        rows: impl IntoIterator<Item = [String; COLUMNS]>,
    ) -> Result<(), Error> {
        let mut text = header.join(",");
        for row in rows {
            text.push('\n');
            text.push_str(&row.join(","));
        }
        text.push('\n');
        self.write(name, text.as_bytes())
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        // removes an unfinished draft; if this fails, the next run does it
        let _ = self.place.recover();
    }
}

/// Whether a stopped run left notes beside its folder, from which the next run resumes.
#[must_use]
pub fn has_notes(path: &Path) -> bool {
    Place::of(path).is_ok_and(|(place, _)| place.notes().exists())
}

/// Path that a file in a draft has once it is published.
pub fn published(file: &Path) -> PathBuf {
    place::published(file).unwrap_or_else(|| file.to_owned())
}

fn json(name: &str, value: &impl serde::Serialize) -> Result<String, Error> {
    let json = serde_json::to_string_pretty(value).map_err(|e| Error::Write { path: name.into(), source: e.into() })?;
    Ok(format!("{json}\n"))
}
