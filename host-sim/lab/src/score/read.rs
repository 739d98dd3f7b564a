//! Reads marks from CSV: header `group,phase,intern,chief,associate,attending` in any order, one
//! row for each intern and phase.

use std::collections::HashMap;
use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};

use super::{FULL_MARK, Phase, ScoreError};

/// Marks of the three physicians for one intern in one phase.
#[derive(Clone, Debug, PartialEq)]
pub struct Marks {
    /// Label of the group.
    pub group: String,
    /// Before or after the training.
    pub phase: Phase,
    /// Label of the intern, unique in the group.
    pub intern: String,
    /// Marks of the chief, the associate chief and the attending physician, from 0 to 10.
    pub marks: [f64; 3],
}

const COLUMNS: [&str; 6] = ["group", "phase", "intern", "chief", "associate", "attending"];

/// Reads the marks in a CSV file.
///
/// # Errors
/// Fails if the file cannot be read, and for the reasons of [`parse`].
pub fn read(path: &Path) -> Result<Vec<Marks>, ScoreError> {
    let bytes = std::fs::read(path).map_err(|source| ScoreError::Read { path: path.into(), source })?;
    parse(&path.display().to_string(), &bytes)
}

/// Reads the marks in the bytes of a CSV file; `path` names the file in errors.
///
/// # Errors
/// Fails if a column is missing, a cell cannot be used, an intern occurs twice in a phase, or the
/// table has no rows.
pub fn parse(path: &str, bytes: &[u8]) -> Result<Vec<Marks>, ScoreError> {
    // spreadsheets begin a file with a byte order mark
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut table = ReaderBuilder::new().trim(Trim::All).comment(Some(b'#')).from_reader(bytes);
    let odd = |error: csv::Error| odd_table(path, &error);
    let header = table.headers().map_err(odd)?.clone();
    if header.iter().all(str::is_empty) {
        return Err(ScoreError::Empty { path: path.into(), what: "the file is empty" });
    }
    let columns = columns(path, &header)?;
    let (mut all, mut seen) = (Vec::new(), HashMap::new());
    for record in table.records() {
        let record = record.map_err(odd)?;
        let line = record.position().map_or(0, csv::Position::line);
        let marks = Row { path, line, record: &record, columns }.marks()?;
        let key = (marks.group.clone(), marks.phase, marks.intern.clone());
        if let Some(first) = seen.insert(key, line) {
            let Marks { group, phase, intern, .. } = marks;
            return Err(ScoreError::Duplicate { path: path.into(), line, first, intern, group, phase: phase.name() });
        }
        all.push(marks);
    }
    if all.is_empty() {
        return Err(ScoreError::Empty { path: path.into(), what: "no row below the header" });
    }
    Ok(all)
}

/// Index of each of [`COLUMNS`] in the header.
fn columns(path: &str, header: &StringRecord) -> Result<[usize; 6], ScoreError> {
    let mut places = [0; 6];
    for (place, column) in places.iter_mut().zip(COLUMNS) {
        *place = header.iter().position(|h| h == column).ok_or_else(|| ScoreError::NoColumn { path: path.into(), column })?;
    }
    if let Some(other) = (0..header.len()).find(|n| !places.contains(n)) {
        let column = header.get(other).unwrap_or_default().to_owned();
        let what = if COLUMNS.contains(&column.as_str()) { "is there twice" } else { "is unknown" };
        return Err(ScoreError::OddColumn { path: path.into(), column, what });
    }
    Ok(places)
}

struct Row<'a> {
    path: &'a str,
    line: u64,
    record: &'a StringRecord,
    columns: [usize; 6],
}

impl Row<'_> {
    fn cell(&self, column: usize) -> &str {
        self.record.get(self.columns[column]).unwrap_or_default()
    }

    fn refused(&self, column: usize, fix: &'static str) -> ScoreError {
        let (path, cell) = (self.path.into(), self.cell(column).into());
        ScoreError::Cell { path, line: self.line, column: COLUMNS[column], cell, fix }
    }

    fn label(&self, column: usize) -> Result<String, ScoreError> {
        let cell = self.cell(column);
        if cell.is_empty() { Err(self.refused(column, "give it a name")) } else { Ok(cell.into()) }
    }

    fn mark(&self, column: usize) -> Result<f64, ScoreError> {
        let mark: f64 = self.cell(column).parse().map_err(|_| self.refused(column, "not a number; marks go from 0 to 10"))?;
        if (0.0..=FULL_MARK).contains(&mark) { Ok(mark) } else { Err(self.refused(column, "marks go from 0 to 10")) }
    }

    fn marks(&self) -> Result<Marks, ScoreError> {
        let phase = Phase::ALL.into_iter().find(|p| p.name() == self.cell(1));
        Ok(Marks {
            group: self.label(0)?,
            phase: phase.ok_or_else(|| self.refused(1, "write before or after"))?,
            intern: self.label(2)?,
            marks: [self.mark(3)?, self.mark(4)?, self.mark(5)?],
        })
    }
}

fn odd_table(path: &str, error: &csv::Error) -> ScoreError {
    let line = error.position().map_or(1, csv::Position::line);
    let what = match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => format!("{len} cells where the header has {expected_len}"),
        csv::ErrorKind::Utf8 { .. } => "not UTF-8".into(),
        other => format!("{other:?}").replace('\n', " "),
    };
    ScoreError::Table { path: path.into(), line, what }
}
