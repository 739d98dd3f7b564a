//! Bad input and failed checks: one line that says what, where, and how to fix it.

use std::path::PathBuf;

use crate::charts::ChartError;
use crate::mesh::MeshError;

/// Why a command did not do what it promises.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene that cannot be read.
    #[error("{0}")]
    Scene(#[from] crate::scene::SceneError),
    /// A mesh that cannot be used.
    #[error("{0}")]
    Mesh(#[from] MeshError),
    /// A live trace that cannot be repeated.
    #[error("{path}: {cause}")]
    Trace {
        /// The file.
        path: PathBuf,
        /// Why not.
        cause: crate::live::trace::TraceError,
    },
    /// Marks that cannot be used.
    #[error("{0}")]
    Score(#[from] crate::score::ScoreError),
    /// Parameters or a model that the core refuses.
    #[error("{0}")]
    Build(#[from] palpate::BuildError),
    /// A patch file that cannot be used.
    #[error("{path}: {cause}")]
    Patch {
        /// The file.
        path: PathBuf,
        /// Why not.
        cause: palpate::BuildError,
    },
    /// A picture that cannot be drawn.
    #[error("{0}")]
    Chart(ChartError),
    /// A file that cannot be written.
    #[error("cannot write {path}: {source}: choose a folder that can be written with --out")]
    Write {
        /// What was to be written.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// An output folder that another run writes.
    #[error("{path}: another run of palpate writes there: wait until it is done or choose another folder with --out")]
    InUse {
        /// The folder.
        path: PathBuf,
    },
    /// A file that cannot be read.
    #[error("cannot read {path}: {source}: check the path")]
    Read {
        /// What was to be read.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// An emulated board that cannot be run.
    #[cfg(not(target_family = "wasm"))]
    #[error("{0}")]
    Emulate(#[from] crate::emulate::EmulateError),
    /// Options that do not fit together.
    #[error("{0}")]
    Usage(String),
    /// A model that cannot keep 1 kHz.
    #[error("{0}")]
    TooSlow(String),
    /// What was promised did not hold; the files are written all the same.
    #[error("check failed: {0}")]
    Check(String),
}

impl Error {
    /// 1 when a check failed, 2 on bad input.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Check(_) => 1,
            _ => 2,
        }
    }
}

impl From<ChartError> for Error {
    fn from(error: ChartError) -> Self {
        match error {
            // a picture is drawn into a draft; its folder is what can be chosen
            ChartError::Write { path, source } => Self::Write { path: crate::output::published(&path), source },
            other => Self::Chart(other),
        }
    }
}
