//! The output folder: files appear whole or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::error::Error;

/// A folder that can be written.
#[derive(Clone, Debug)]
pub struct OutputFolder(PathBuf);

impl OutputFolder {
    /// Makes the folder and tries to write in it, before anything is computed.
    ///
    /// # Errors
    /// It cannot be made or written.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let refuse = |source| Error::Write { path: path.into(), source };
        std::fs::create_dir_all(path).map_err(refuse)?;
        tempfile::tempfile_in(path).map_err(refuse)?;
        Ok(Self(path.into()))
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Writes a file under a temporary name, then renames it.
    ///
    /// # Errors
    /// The disk is full, or the folder has gone.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Error> {
        let path = self.0.join(name);
        let refuse = |source| Error::Write { path: path.clone(), source };
        let mut file = tempfile::Builder::new().prefix(".partial-").tempfile_in(&self.0).map_err(refuse)?;
        file.write_all(bytes).map_err(refuse)?;
        readable_by_all(file.as_file()).map_err(refuse)?;
        file.persist(&path).map_err(|e| refuse(e.error))?;
        Ok(())
    }

    /// Writes a value as JSON.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn write_json(&self, name: &str, value: &impl serde::Serialize) -> Result<(), Error> {
        let json = serde_json::to_string_pretty(value).map_err(|e| Error::Write { path: self.0.join(name), source: e.into() })?;
        self.write(name, format!("{json}\n").as_bytes())
    }

    /// Writes rows as CSV under a header.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn write_csv<const COLUMNS: usize>(
        &self,
        name: &str,
        header: [&str; COLUMNS],
        rows: impl IntoIterator<Item = [f64; COLUMNS]>,
    ) -> Result<(), Error> {
        let mut text = header.join(",");
        for row in rows {
            text.push('\n');
            // the shortest decimal that reads back as the same number
            let cells = row.map(|v| v.to_string());
            text.push_str(&cells.join(","));
        }
        text.push('\n');
        self.write(name, text.as_bytes())
    }
}

/// Temporary files are private; results are not.
#[cfg(unix)]
fn readable_by_all(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable_by_all(_: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}
