//! Errors of the stored dynamic references.

/// Why a stored reference cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TruthError {
    /// The file of a reference cannot be read.
    #[error("{file}, line {line}: {why}")]
    Table {
        /// Name of the file.
        file: String,
        /// Line, counted from 1.
        line: usize,
        /// Defect of the line, and how to fix it.
        why: &'static str,
    },
    /// No stored reference has this name.
    #[error("no truth is called {name}: see TRUTHS for the names")]
    Unknown {
        /// The requested name.
        name: String,
    },
    /// A motion other than a ramp, where a ramp is needed.
    #[error("{name} is no ramp")]
    NoRamp {
        /// Name of the reference.
        name: &'static str,
    },
}
