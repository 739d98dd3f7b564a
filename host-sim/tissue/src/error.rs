//! Errors for bad input and for failed checks. Each message is one line that says what is wrong,
//! where, and how to fix it.

use std::path::PathBuf;

use crate::mesh::MeshError;

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene that cannot be read.
    #[error("{0}")]
    Scene(#[from] crate::scene::SceneError),
    /// A mesh that cannot be used.
    #[error("{0}")]
    Mesh(#[from] MeshError),
    /// A stored dynamic reference of a moving probe that cannot be used.
    #[error("{0}")]
    Truth(#[from] crate::truth_error::TruthError),
    /// Parameters or a model that the core refuses.
    #[error("{0}")]
    Build(#[from] palpate::BuildError),
    /// A patch file that cannot be used.
    #[error("{path}: {cause}")]
    Patch {
        /// Path of the patch file.
        path: PathBuf,
        /// Cause of the failure.
        cause: palpate::BuildError,
    },
    /// A file that cannot be written.
    #[error("cannot write {path}: {source}: choose a folder that can be written with --out")]
    Write {
        /// Path to be written.
        path: PathBuf,
        /// Cause of the failure.
        source: std::io::Error,
    },
    /// An output folder that another run is writing.
    #[error("{path}: another run of palpate writes there: wait until it is done or choose another folder with --out")]
    InUse {
        /// Path of the output folder.
        path: PathBuf,
    },
    /// A file that cannot be read.
    #[error("cannot read {path}: {source}: check the path")]
    Read {
        /// Path to be read.
        path: PathBuf,
        /// Cause of the failure.
        source: std::io::Error,
    },
    /// Command-line options that exclude each other, or an option that cannot be used here.
    #[error("{0}")]
    Usage(String),
    /// A model whose tick takes too long for 1 kHz.
    #[error("{0}")]
    TooSlow(String),
    /// A check that failed; the output files are written nevertheless.
    #[error("check failed: {0}")]
    Check(String),
}

impl Error {
    /// Exit code of the program: 1 if a check failed, 2 on bad input.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Check(_) => 1,
            _ => 2,
        }
    }
}
