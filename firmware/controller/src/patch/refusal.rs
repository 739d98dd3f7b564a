//! Reason for which a board refuses a patch, as it is sent to the host.

use palpate::BuildError;

use super::{DASHPOT, EXPONENT, MODULUS, SUBSTEP, TICK, contact, cost, site, step};
use crate::refusal::Refusal;

impl From<BuildError> for Refusal {
    fn from(error: BuildError) -> Self {
        match error {
            BuildError::Checksum { .. } => Self::PatchDamaged,
            BuildError::NotAPatch => Self::PatchVersion,
            BuildError::NoSuchTip => Self::PatchTip,
            BuildError::TooLarge { .. } | BuildError::LengthMismatch { .. } => Self::PatchTooLarge,
            BuildError::OutOfRange {
                parameter: SUBSTEP | TICK | DASHPOT | step::FLOOR | step::SERIES | step::CONTACT, ..
            } => Self::PatchStep,
            BuildError::OutOfRange { parameter: cost::COST | EXPONENT, .. } => Self::PatchCost,
            BuildError::OutOfRange {
                parameter: site::SITE | site::AXIS | site::AXIS_LENGTH | site::DEPTH | contact::PUSH,
                ..
            } => Self::PatchSite,
            BuildError::OutOfRange { parameter: MODULUS, .. } => Self::ModulusOutOfRange,
            _ => Self::PatchInvalid,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_says_what_is_wrong_with_the_patch() {
        let size = BuildError::TooLarge { item: "nodes", need: 2, have: 1 };
        let length = BuildError::LengthMismatch { item: "springs", need: 2, have: 1 };
        let range = |parameter| BuildError::OutOfRange { parameter, value: 2.0, min: 0.0, max: 1.0 };
        let refusals = [
            (BuildError::Checksum { expected: 1, found: 2 }, Refusal::PatchDamaged),
            (BuildError::NotAPatch, Refusal::PatchVersion),
            (BuildError::NoSuchTip, Refusal::PatchTip),
            (size, Refusal::PatchTooLarge),
            (length, Refusal::PatchTooLarge),
            (range(SUBSTEP), Refusal::PatchStep),
            (range(cost::COST), Refusal::PatchCost),
            (range(EXPONENT), Refusal::PatchCost),
            (range(site::AXIS), Refusal::PatchSite),
            (range(contact::PUSH), Refusal::PatchSite),
            (range(MODULUS), Refusal::ModulusOutOfRange),
            (range("poisson_ratio"), Refusal::PatchInvalid),
            (BuildError::Empty, Refusal::PatchInvalid),
        ];
        for (error, refusal) in refusals {
            assert_eq!(Refusal::from(error), refusal);
        }
    }
}
