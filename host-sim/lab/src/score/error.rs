//! Errors in a file of marks. Each message is one line that states the problem, its place, and how
//! to fix it.

use std::path::PathBuf;

/// Reason why marks or weights were refused.
#[derive(Debug, thiserror::Error)]
pub enum ScoreError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}: check the path", path.display())]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// Cause of the failure.
        source: std::io::Error,
    },
    /// No header, or no row below it.
    #[error(
        "{path}: {what}: write the header group,phase,intern,chief,associate,attending and one row for each intern and phase"
    )]
    Empty {
        /// Path of the file.
        path: String,
        /// Statement of what is missing.
        what: &'static str,
    },
    /// A column of the header is not there.
    #[error("{path}:1: column \"{column}\" is missing: the header is group,phase,intern,chief,associate,attending")]
    NoColumn {
        /// Path of the file.
        path: String,
        /// Name of the missing column.
        column: &'static str,
    },
    /// A column of the header that is unknown or occurs twice.
    #[error("{path}:1: column \"{column}\" {what}: the header is group,phase,intern,chief,associate,attending")]
    OddColumn {
        /// Path of the file.
        path: String,
        /// Name of the column, as written.
        column: String,
        /// Reason why the column is refused.
        what: &'static str,
    },
    /// A cell that cannot be used.
    #[error("{path}:{line}: {column} is \"{cell}\": {fix}")]
    Cell {
        /// Path of the file.
        path: String,
        /// Line, from 1.
        line: u64,
        /// Name of the column.
        column: &'static str,
        /// Content of the cell, as written.
        cell: String,
        /// Instruction on how to correct the cell.
        fix: &'static str,
    },
    /// An intern who is marked twice in the same phase.
    #[error(
        "{path}:{line}: intern \"{intern}\" of group \"{group}\" is marked {phase} twice, first in line {first}: keep one row"
    )]
    Duplicate {
        /// Path of the file.
        path: String,
        /// Line of the second row.
        line: u64,
        /// Line of the first row.
        first: u64,
        /// Name of the intern in both rows.
        intern: String,
        /// Group of both rows.
        group: String,
        /// Phase of the training in both rows.
        phase: &'static str,
    },
    /// The file is not a table.
    #[error("{path}:{line}: {what}: write six cells separated by commas, UTF-8")]
    Table {
        /// Path of the file.
        path: String,
        /// Line, from 1.
        line: u64,
        /// Reason why the row cannot be read.
        what: String,
    },
    /// Weights that are not shares.
    #[error(
        "--weights {},{},{} sum to {}: give three shares above zero that sum to 1, such as 0.45,0.35,0.20",
        shares[0], shares[1], shares[2], (sum * 1e9).round() / 1e9
    )]
    Weights {
        /// The three weights, as given.
        shares: [f64; 3],
        /// Sum of the three weights.
        sum: f64,
    },
    /// Weights that are not three numbers.
    #[error("--weights {text}: not three numbers: give three shares above zero that sum to 1, such as 0.45,0.35,0.20")]
    WeightsUnread {
        /// Text of the option, as given.
        text: String,
    },
}
