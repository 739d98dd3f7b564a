//! Records of a board as CSV: a file that appears when it is complete, and one that grows as
//! records arrive.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use palpate_controller::link::{Identity, Record};
use palpate_loop::board_trace::COLUMNS;
use palpate_tissue::Error as TissueError;
use tempfile::NamedTempFile;

use super::super::status::spent_us;
use super::writer::Sink;
use crate::error::Error;

/// The files of a run.
#[derive(Default)]
pub(super) struct Files {
    whole: Option<Rows>,
    growing: Option<Growing>,
}

impl Files {
    /// Begins the requested files.
    pub(super) fn begin(whole: Option<&Path>, growing: Option<&Path>) -> Result<Self, Error> {
        if let (Some(whole), Some(growing)) = (whole, growing)
            && whole == growing
        {
            let why = format!("{}: --out and --stream name the same file: give them two", whole.display());
            return Err(TissueError::Usage(why).into());
        }
        Ok(Self { whole: whole.map(Rows::begin).transpose()?, growing: growing.map(Growing::begin).transpose()? })
    }

    /// Ends the run; returns the files that were written.
    pub(super) fn publish(self) -> Result<Vec<PathBuf>, Error> {
        let mut written: Vec<PathBuf> = self.growing.into_iter().map(|growing| growing.0.path).collect();
        if let Some(whole) = self.whole {
            written.push(whole.0.path.clone());
            whole.publish()?;
        }
        Ok(written)
    }
}

impl Sink for Files {
    /// Adds a row to each file.
    fn add(&mut self, record: &Record, identity: &Identity) -> Result<(), Error> {
        if let Some(growing) = &mut self.growing {
            growing.add(record, identity)?;
        }
        self.whole.as_mut().map_or(Ok(()), |whole| whole.add(record, identity))
    }
}

/// A file that is written under a temporary name in its own folder.
struct Rows(Table<BufWriter<NamedTempFile>>);

impl Rows {
    /// Creates the temporary file and writes the column headings.
    fn begin(path: &Path) -> Result<Self, Error> {
        let folder = folder_of(path, "--out")?;
        let file = readable(folder).map_err(|source| TissueError::Write { path: path.into(), source })?;
        Ok(Self(Table::begin(path, BufWriter::new(file))?))
    }

    /// Adds a row.
    fn add(&mut self, record: &Record, identity: &Identity) -> Result<(), Error> {
        self.0.add(record, identity)
    }

    /// Renames the file to its final name, in place of an earlier one.
    fn publish(self) -> Result<(), Error> {
        let path = self.0.path;
        let refuse = |source| TissueError::Write { path: path.clone(), source };
        let file = self.0.rows.into_inner().map_err(|e| refuse(e.into_error()))?;
        let file = file.into_inner().map_err(|e| refuse(e.into_error()))?;
        file.as_file().sync_all().map_err(refuse)?;
        file.persist(&path).map_err(|e| refuse(e.error))?;
        Ok(())
    }
}

/// A stream that is written under its final name, so that other programs can read it while it
/// grows.
struct Growing(Table<File>);

impl Growing {
    /// Begins the file; earlier rows are removed.
    fn begin(path: &Path) -> Result<Self, Error> {
        folder_of(path, "--stream")?;
        let file = File::create(path).map_err(|source| TissueError::Write { path: path.into(), source })?;
        let mut table = Table::begin(path, file)?;
        table.flush()?;
        Ok(Self(table))
    }

    /// Adds a row, which a reader can read at once.
    fn add(&mut self, record: &Record, identity: &Identity) -> Result<(), Error> {
        self.0.add(record, identity)?;
        self.0.flush()
    }
}

/// Creates a temporary file with the permissions of any new file, not those of a secret one.
#[cfg(unix)]
fn readable(folder: &Path) -> std::io::Result<NamedTempFile> {
    use std::os::unix::fs::PermissionsExt;
    tempfile::Builder::new().permissions(std::fs::Permissions::from_mode(0o666)).tempfile_in(folder)
}

#[cfg(not(unix))]
fn readable(folder: &Path) -> std::io::Result<NamedTempFile> {
    NamedTempFile::new_in(folder)
}

/// Folder of a file that an option names, created if it is missing.
fn folder_of<'a>(path: &'a Path, option: &str) -> Result<&'a Path, Error> {
    if path.is_dir() {
        let why = format!("{}: this is a folder: give the name of a CSV file with {option}", path.display());
        return Err(TissueError::Usage(why).into());
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|source| TissueError::Write { path: path.into(), source })?;
    Ok(folder)
}

/// Rows on their way to a file.
struct Table<W: Write> {
    path: PathBuf,
    rows: csv::Writer<W>,
}

impl<W: Write> Table<W> {
    fn begin(path: &Path, file: W) -> Result<Self, Error> {
        let mut table = Self { path: path.into(), rows: csv::Writer::from_writer(file) };
        table.row(COLUMNS.iter().map(ToString::to_string))?;
        Ok(table)
    }

    fn add(&mut self, record: &Record, identity: &Identity) -> Result<(), Error> {
        let whole = [u32::from(record.mode), u32::from(record.fault)].map(|n| n.to_string());
        let real = [record.position_m, [record.depth_m, record.model_n[0], record.model_n[1]]].concat();
        let real = real.into_iter().chain([record.model_n[2]]).chain(record.applied_n).map(|n| n.to_string());
        let codes = record.codes.map(|code| code.to_string());
        let counts = [record.active_nodes, record.limiters.into(), record.patch_limiters.into()].map(|n| n.to_string());
        let us = spent_us(record, identity).map_or_else(String::new, |us| format!("{us:.2}"));
        let patch = [format!("{:08x}", identity.patch_checksum), identity.youngs_modulus_pa.to_string()];
        let row = [record.tick.to_string()].into_iter().chain(whole).chain(real);
        let row = row.chain([u8::from(record.enabled).to_string()]).chain(codes).chain(counts);
        self.row(row.chain([record.energy_j[0].to_string(), us]).chain(patch))
    }

    fn row(&mut self, cells: impl Iterator<Item = String>) -> Result<(), Error> {
        self.rows.write_record(cells.collect::<Vec<_>>()).map_err(|cause| self.refused(cause.into()))
    }

    fn flush(&mut self) -> Result<(), Error> {
        self.rows.flush().map_err(|source| self.refused(source))
    }

    fn refused(&self, source: std::io::Error) -> Error {
        TissueError::Write { path: self.path.clone(), source }.into()
    }
}

#[cfg(test)]
pub(super) mod example;
#[cfg(test)]
mod tests;
