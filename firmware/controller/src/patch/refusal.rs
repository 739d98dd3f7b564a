//! Why a board refuses a patch, as the host is told.

use palpate::BuildError;

use super::{MODULUS, SUBSTEP, TICK, cost, site, step};
use crate::link::Refusal;

impl From<BuildError> for Refusal {
    fn from(error: BuildError) -> Self {
        match error {
            BuildError::Checksum { .. } => Self::PatchDamaged,
            BuildError::NotAPatch => Self::PatchVersion,
            BuildError::TooLarge { .. } | BuildError::LengthMismatch { .. } => Self::PatchTooLarge,
            BuildError::OutOfRange { parameter: SUBSTEP | TICK | step::FLOOR, .. } => Self::PatchStep,
            BuildError::OutOfRange { parameter: cost::COST, .. } => Self::PatchCost,
            BuildError::OutOfRange { parameter: site::SITE | site::AXIS | site::AXIS_LENGTH | site::DEPTH, .. } => {
                Self::PatchSite
            }
            BuildError::OutOfRange { parameter: MODULUS, .. } => Self::ModulusOutOfRange,
            _ => Self::PatchInvalid,
        }
    }
}
