//! Errors of commands: one line that says what, where, and how to fix it.

use std::path::PathBuf;

use palpate_charts::ChartError;
use palpate_tissue::Error as TissueError;

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An error of a scene, patch or file, or a failed check.
    #[error("{0}")]
    Tissue(#[from] TissueError),
    /// A live trace that cannot be replayed.
    #[error("{path}: {cause}")]
    Trace {
        /// Path of the trace.
        path: PathBuf,
        /// Cause of the failure.
        cause: palpate_loop::live::trace::TraceError,
    },
    /// A picture that cannot be drawn.
    #[error("{0}")]
    Chart(ChartError),
    /// A board on a serial port that did not follow a request.
    #[cfg(feature = "full")]
    #[error("{0}")]
    Port(#[from] crate::port::PortError),
    /// An emulated board that cannot be run.
    #[cfg(feature = "full")]
    #[error("{0}")]
    Emulate(#[from] palpate_board::EmulateError),
}

impl Error {
    /// 1 when a check failed, 2 on bad input.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Tissue(TissueError::Check(_)) => 1,
            _ => 2,
        }
    }
}

impl From<ChartError> for Error {
    fn from(error: ChartError) -> Self {
        match error {
            // a picture is drawn into a draft folder; the user chose the published folder
            ChartError::Write { path, source } => {
                Self::Tissue(TissueError::Write { path: palpate_tissue::output::published(&path), source })
            }
            other => Self::Chart(other),
        }
    }
}

// converts in one step, so that a command can use `?`
macro_rules! of_tissue {
    ($($error:ty),*) => {
        $(impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self::Tissue(error.into())
            }
        })*
    };
}
of_tissue!(palpate_tissue::scene::SceneError, palpate_tissue::mesh::MeshError, palpate::BuildError);
