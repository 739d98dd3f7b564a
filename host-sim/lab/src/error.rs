//! Error type of the comparisons.

use palpate_charts::ChartError;
use palpate_tissue::Error as TissueError;

/// Reason why a comparison did not finish, or the claim that it refuted.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A bad scene, patch or file, or a check that failed.
    #[error("{0}")]
    Tissue(#[from] TissueError),
    /// A picture that cannot be drawn.
    #[error("{0}")]
    Chart(ChartError),
}

impl From<ChartError> for Error {
    fn from(error: ChartError) -> Self {
        match error {
            // a picture is drawn into a draft folder; the error names the folder that the user
            // chose
            ChartError::Write { path, source } => {
                Self::Tissue(TissueError::Write { path: palpate_tissue::output::published(&path), source })
            }
            other => Self::Chart(other),
        }
    }
}

// lets `?` convert these errors in one step
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

impl From<Error> for palpate_sim::error::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Tissue(error) => Self::Tissue(error),
            Error::Chart(error) => Self::Chart(error),
        }
    }
}
