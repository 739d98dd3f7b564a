//! Reads the rows of a table while another program writes it.

use std::fs::File;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use palpate_loop::board_trace::{Columns, Row};

/// Number of bytes before the position read so far that are compared again: they differ if the file
/// was replaced.
const KEPT: usize = 512;

/// Outcome of a read of the file.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// The file does not exist.
    Absent,
    /// The file has these new rows.
    Rows(Rows),
    /// The file is not a table of a board's records: file and line, the reason, and the fix.
    Bad(String),
}

/// Rows that were added since the last read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// Whether the file was replaced since the last read, or started again.
    pub anew: bool,
    /// Complete rows only, in their order.
    pub rows: Vec<Row>,
    /// Time since the file was last written to.
    pub age: Duration,
}

/// Position in a growing file.
#[derive(Debug)]
pub struct Tail {
    path: PathBuf,
    /// Number of bytes read so far.
    offset: u64,
    /// The last of the bytes read so far.
    kept: Vec<u8>,
    /// Beginning of a line that is not complete yet.
    part: Vec<u8>,
    /// Number of lines read so far.
    lines: u64,
    columns: Option<Columns>,
    /// Error of a line that cannot be read; nothing after it is read until the file starts again.
    bad: Option<String>,
}

impl Tail {
    /// Starts to follow a file that may not exist yet.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        Self { path: path.into(), offset: 0, kept: Vec::new(), part: Vec::new(), lines: 0, columns: None, bad: None }
    }

    /// Reads the new rows.
    pub fn read(&mut self) -> Found {
        match self.look() {
            Ok(Some(mut found)) => {
                found.anew |= self.offset == 0;
                match self.take(&found.bytes, found.anew) {
                    Ok(rows) => Found::Rows(Rows { anew: found.anew, rows, age: found.age }),
                    Err(why) => Found::Bad(why),
                }
            }
            Ok(None) => {
                *self = Self::of(&self.path);
                Found::Absent
            }
            Err(why) => {
                *self = Self::of(&self.path);
                Found::Bad(format!("{}: cannot be read: {why}: give a file that you may read", self.path.display()))
            }
        }
    }

    /// New bytes of the file; `None` if there is no file.
    fn look(&self) -> std::io::Result<Option<Came>> {
        let file = match File::open(&self.path) {
            Err(why) if why.kind() == ErrorKind::NotFound => return Ok(None),
            opened => opened?,
        };
        let about = file.metadata()?;
        if about.is_dir() {
            return Err(std::io::Error::other("it is a folder"));
        }
        // the file's time may be ahead of this machine's clock: its age is then zero
        let age = about.modified().ok().and_then(|at| SystemTime::now().duration_since(at).ok()).unwrap_or_default();
        let came = |bytes, anew| Ok(Some(Came { bytes, anew, age }));
        if about.len() == self.offset && self.offset > 0 && self.kept == bytes_from(&file, self.kept_from(), self.offset)? {
            return came(Vec::new(), false);
        }
        if about.len() > self.offset {
            let bytes = bytes_from(&file, self.kept_from(), u64::MAX)?;
            if let Some(new) = bytes.strip_prefix(&self.kept[..]) {
                return came(new.to_vec(), false);
            }
        }
        came(bytes_from(&file, 0, u64::MAX)?, true)
    }

    fn kept_from(&self) -> u64 {
        self.offset - self.kept.len() as u64
    }

    fn take(&mut self, bytes: &[u8], anew: bool) -> Result<Vec<Row>, String> {
        if anew {
            *self = Self::of(&self.path);
        }
        self.offset += bytes.len() as u64;
        self.kept.extend(&bytes[bytes.len().saturating_sub(KEPT)..]);
        self.kept.drain(..self.kept.len().saturating_sub(KEPT));
        if let Some(why) = &self.bad {
            return Err(why.clone());
        }
        self.part.extend(bytes);
        let whole = self.part.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        let text: Vec<u8> = self.part.drain(..whole).collect();
        let mut rows = Vec::new();
        for line in text.split(|byte| *byte == b'\n').filter(|line| !line.is_empty()) {
            self.lines += 1;
            match self.line(&String::from_utf8_lossy(line)) {
                Ok(row) => rows.extend(row),
                Err(why) => {
                    let why = format!("{}:{}: {why}", self.path.display(), self.lines);
                    self.bad = Some(why.clone());
                    return Err(why);
                }
            }
        }
        Ok(rows)
    }

    fn line(&mut self, line: &str) -> Result<Option<Row>, String> {
        if let Some(columns) = &self.columns {
            return columns.row(line).map(Some);
        }
        self.columns = Some(Columns::of(line)?);
        Ok(None)
    }
}

struct Came {
    bytes: Vec<u8>,
    anew: bool,
    age: Duration,
}

fn bytes_from(mut file: &File, from: u64, to: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(from))?;
    file.take(to - from).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests;
