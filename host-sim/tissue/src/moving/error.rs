//! Reasons for which a stored truth cannot be used.

/// Why a table cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TruthError {
    /// The stored table of truths cannot be read.
    #[error("{file}, line {line}: {why}")]
    Table {
        /// Name of the file.
        file: String,
        /// Line, counted from 1.
        line: usize,
        /// Reason.
        why: &'static str,
    },
    /// The stored table of truths has no entry of that name.
    #[error("no truth is called {name}: see TRUTHS for the names")]
    Unknown {
        /// The requested name.
        name: String,
    },
    /// A drag where a ramp is needed.
    #[error("{name} is no ramp")]
    NoRamp {
        /// Name of the truth.
        name: &'static str,
    },
}
