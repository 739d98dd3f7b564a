//! Why a comparison did not finish.

use palpate_charts::ChartError;
use palpate_tissue::Error as TissueError;

use crate::score::ScoreError;

/// Why a comparison did not finish, or which of its claims did not hold.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene, patch, file or check.
    #[error("{0}")]
    Tissue(#[from] TissueError),
    /// A picture that cannot be drawn.
    #[error("{0}")]
    Chart(ChartError),
    /// Marks that cannot be used.
    #[error("{0}")]
    Score(#[from] ScoreError),
}

impl From<ChartError> for Error {
    fn from(error: ChartError) -> Self {
        match error {
            // a picture is drawn into a draft; the user can choose its folder
            ChartError::Write { path, source } => {
                Self::Tissue(TissueError::Write { path: palpate_tissue::output::published(&path), source })
            }
            other => Self::Chart(other),
        }
    }
}

// converts for `?` in one step
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
