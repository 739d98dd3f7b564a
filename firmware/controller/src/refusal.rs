//! Reasons why the controller refuses a request.

pub mod contact;

use core::fmt;

use serde::{Deserialize, Serialize};

use self::contact::{TooNarrow, TooStiff};
use crate::config::{ProfileError, StoreError};
use crate::kinematics::MechanismError;

/// Why a request was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Refusal {
    /// Patches and profiles are accepted in `Idle` only, a change of modulus also in the modes with
    /// force.
    NotIdle,
    /// A limit would rise, or is not a number.
    LimitRises,
    /// Young's modulus is not between half and twice the patch's own.
    ModulusOutOfRange,
    /// The patch is longer than the memory for it.
    PatchTooLong,
    /// A piece of the patch is missing or out of order, or no patch was announced.
    PatchPieces,
    /// The checksum of the patch does not match.
    PatchDamaged,
    /// The bytes are no patch of this version.
    PatchVersion,
    /// The patch has more nodes or triangles than the memory holds.
    PatchTooLarge,
    /// The patch needs another tick, smaller substeps, heavier nodes or a softer contact for
    /// stability.
    PatchStep,
    /// The mesh or the parameters of the patch are invalid.
    PatchInvalid,
    /// There is no patch yet.
    NoPatch,
    /// A number of the profile is out of its range.
    ProfileRange,
    /// The profile memory cannot store the profile.
    FlashFailed,
    /// A tick of the patch costs more than the board's budget, or the patch stiffens, which no
    /// board computes.
    PatchCost,
    /// The site, the axis or the depth limit of the patch does not fit its surface.
    PatchSite,
    /// The probe of the patch is a capsule or an ellipsoid, which the image does not include.
    PatchTip,
    /// The mechanism of the profile is impossible, or cannot move as the profile says.
    Mechanism(MechanismError),
    /// The device has not been homed since power-on, or its encoders failed since.
    NotHomed,
    /// The device's joints have no encoders.
    NoEncoders,
    /// The board crashed too often: it arms again only after power-on or its reset button.
    Barred,
    /// The contact is stiffer than the stiffness ceiling of the device's profile.
    ContactStiff(TooStiff),
    /// The tip is narrower than the elements of the patch under it.
    TipNarrow(TooNarrow),
    /// A number of a commissioning is out of its range.
    Commissioning,
}

impl From<StoreError> for Refusal {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Profile(ProfileError::Range(_)) => Self::ProfileRange,
            StoreError::Profile(ProfileError::Mechanism(error)) => Self::Mechanism(error),
            StoreError::Flash => Self::FlashFailed,
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mechanism(error) => return error.fmt(f),
            Self::ContactStiff(contact) => return contact.fmt(f),
            Self::TipNarrow(tip) => return tip.fmt(f),
            Self::NotHomed => "the home pose is not known: hold the device in it and run `palpate board home`",
            Self::NoEncoders => "no encoder of this board answers: check the wiring, or send the board its readings",
            Self::Barred => {
                "the board crashed three times within a minute and arms no more: switch it off and on, and see its log for the cause"
            }
            Self::Commissioning => "the numbers of the commissioning are out of range: give a distance between 5 mm and 0.5 m, and check the profile's encoders and motors",
            Self::NotIdle => "the board is not idle: stop it first, or clear its fault",
            Self::LimitRises => "a limit would rise or is no number: limits can only be lowered",
            Self::ModulusOutOfRange => "Young's modulus must be between half and twice that of the patch: pack another patch",
            Self::PatchTooLong => {
                "the patch is longer than the board's memory for one: take a smaller patch, or build it into the image"
            }
            Self::PatchPieces => "a piece of the patch is missing: send it again from its beginning",
            Self::PatchDamaged => "the patch is damaged: its checksum does not match; send it again",
            Self::PatchVersion => "the patch is of another version: pack it again with this palpate",
            Self::PatchTooLarge => "the patch has more nodes or triangles than the board holds: take a smaller one",
            Self::PatchStep => {
                "the patch needs another step than the board makes: pack it for ticks of 1 ms, with more substeps or a larger mass floor"
            }
            Self::PatchInvalid => "the patch's mesh or parameters are wrong: check the mesh and pack it again",
            Self::NoPatch => "there is no patch yet: send one first",
            Self::ProfileRange => "a number of the profile is out of its range: check it against the limits of the loop",
            Self::FlashFailed => "the memory for the profile does not keep it: the one before still holds",
            Self::PatchCost => "a tick of the patch costs more than the board has: take a smaller patch or fewer substeps",
            Self::PatchSite => "site, axis or depth limit of the patch do not fit its surface: check them and pack it again",
            Self::PatchTip => "the board's image has no capsule or ellipsoid: take a hemisphere, sphere or flat tip",
        })
    }
}
