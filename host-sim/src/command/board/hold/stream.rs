//! Records of a board as a CSV file that appears whole.

use std::io::BufWriter;
use std::path::{Path, PathBuf};

use palpate_controller::link::{Identity, Record};
use palpate_tissue::Error as TissueError;
use tempfile::NamedTempFile;

use super::super::status::spent_us;
use crate::error::Error;

const HEAD: [&str; 22] = [
    "tick",
    "mode",
    "fault",
    "x_m",
    "y_m",
    "z_m",
    "depth_m",
    "model_x_n",
    "model_y_n",
    "model_z_n",
    "applied_x_n",
    "applied_y_n",
    "applied_z_n",
    "outputs_on",
    "code_x",
    "code_y",
    "code_z",
    "active_nodes",
    "limiters",
    "patch_limiters",
    "energy_given_j",
    "tick_us",
];

/// A file being written, under another name beside its place.
pub(super) struct Rows {
    path: PathBuf,
    rows: csv::Writer<BufWriter<NamedTempFile>>,
}

impl Rows {
    /// Begins the file.
    pub(super) fn begin(path: &Path) -> Result<Self, Error> {
        let refuse = |source| TissueError::Write { path: path.into(), source };
        if path.is_dir() {
            return Err(TissueError::Usage(format!(
                "{}: this is a folder: give the name of a CSV file with --out",
                path.display()
            ))
            .into());
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).map_err(refuse)?;
        let file = NamedTempFile::new_in(folder).map_err(refuse)?;
        let mut rows = Self { path: path.into(), rows: csv::Writer::from_writer(BufWriter::new(file)) };
        rows.row(HEAD.iter().map(ToString::to_string))?;
        Ok(rows)
    }

    /// A row.
    pub(super) fn add(&mut self, record: &Record, identity: &Identity) -> Result<(), Error> {
        let whole = [u32::from(record.mode), u32::from(record.fault)].map(|n| n.to_string());
        let real = [record.position_m, [record.depth_m, record.model_n[0], record.model_n[1]]].concat();
        let real = real.into_iter().chain([record.model_n[2]]).chain(record.applied_n).map(|n| n.to_string());
        let codes = record.codes.map(|code| code.to_string());
        let counts = [record.active_nodes, record.limiters.into(), record.patch_limiters.into()].map(|n| n.to_string());
        let us = spent_us(record, identity).map_or_else(String::new, |us| format!("{us:.2}"));
        let row = [record.tick.to_string()].into_iter().chain(whole).chain(real);
        let row = row.chain([u8::from(record.enabled).to_string()]).chain(codes).chain(counts);
        self.row(row.chain([record.energy_j[0].to_string(), us]))
    }

    fn row(&mut self, cells: impl Iterator<Item = String>) -> Result<(), Error> {
        self.rows.write_record(cells.collect::<Vec<_>>()).map_err(|cause| self.refused(cause.into()))
    }

    fn refused(&self, source: std::io::Error) -> Error {
        TissueError::Write { path: self.path.clone(), source }.into()
    }

    /// Puts the file in its place, over an earlier one.
    pub(super) fn publish(self) -> Result<(), Error> {
        let refuse = |source| TissueError::Write { path: self.path.clone(), source };
        let file = self.rows.into_inner().map_err(|e| refuse(e.into_error()))?;
        let file = file.into_inner().map_err(|e| refuse(e.into_error()))?;
        file.as_file().sync_all().map_err(refuse)?;
        file.persist(&self.path).map_err(|e| refuse(e.error))?;
        Ok(())
    }
}
