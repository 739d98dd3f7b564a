//! Messages of the link.

use core::fmt;

use palpate::haptic::cycle::Ask;
use serde::{Deserialize, Serialize};

use super::log::Log;
use super::record::Record;
use super::wire_limits::WireLimits;
use crate::about::About;
use crate::config::{Profile, ProfileError, StoreError};
use crate::kinematics::MechanismError;

/// From the host. Every message counts as a sign of life.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ToBoard<'a> {
    /// A sign of life, nothing else.
    Heartbeat,
    /// A reading in place of the board's own sensors, device frame [m]: ends the input of a
    /// lock-step tick.
    Pose {
        /// Tip [m].
        position_m: [f32; 3],
        /// Number of the reading.
        sequence: u32,
        /// False: the sensor says that it cannot be trusted.
        good: bool,
    },
    /// A request to the mode machine.
    Ask(HostAsk),
    /// Stricter limits, in any mode.
    LowerLimits(WireLimits),
    /// Another Young's modulus [Pa], between half and twice that of the patch as it was packed. In
    /// `Idle` the patch is put to rest with it; under force a softer one applies at once, a stiffer
    /// one as soon as nothing touches.
    YoungsModulus(f32),
    /// A patch of this many bytes will follow, in `Idle`.
    PatchBegin(u32),
    /// A piece of the patch; pieces come in order.
    PatchPart {
        /// Bytes of the patch before this piece.
        at: u32,
        /// The piece.
        #[serde(borrow)]
        bytes: &'a [u8],
    },
    /// End of the patch.
    PatchEnd,
    /// Report the state.
    Report,
    /// Keep a profile over power-off, in `Idle`; the controller starts up anew with it.
    Store(Profile),
    /// The actuators' supply is too low: for boards that cannot see it themselves.
    SupplyLow,
    /// The stop circuit is open: for boards that cannot see it themselves.
    EmergencyStop,
    /// Whether the operator's switch is pressed, for boards without a pin for it; holds until the
    /// next such message, and counts as released before the first.
    Operator(bool),
    /// Identify the board.
    Identify,
    /// Counts of the encoders in place of the board's own, otherwise as [`Self::Pose`].
    Joints {
        /// One per joint, in the mechanism's order.
        counts: [i32; 3],
        /// Number of the reading.
        sequence: u32,
        /// False: the encoders say that they cannot be trusted.
        good: bool,
    },
    /// The device is in its home pose now, in `Idle`.
    Home,
    /// Whether the host takes the log: if so, for the next [`crate::serve::LISTENS_TICKS`].
    Listen(bool),
}

/// Requests of a host to the mode machine; start-up is the board's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum HostAsk {
    /// Arm: enable force output.
    Arm,
    /// Stop: end force output and disarm.
    Stop,
    /// Clear the latched fault.
    Clear,
}

impl From<HostAsk> for Ask {
    fn from(asked: HostAsk) -> Self {
        match asked {
            HostAsk::Arm => Self::Arm,
            HostAsk::Stop => Self::Stop,
            HostAsk::Clear => Self::Clear,
        }
    }
}

/// From the board.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum FromBoard {
    /// Record of a tick.
    Record(Record),
    /// A request was not carried out.
    Refused(Refusal),
    /// A patch of this many nodes is ready, at rest.
    PatchTaken(u32),
    /// The profile is in use and kept as the n-th; 0: the board cannot store it, and it is valid
    /// until power-off.
    Stored(u32),
    /// The answer to [`ToBoard::Report`].
    State {
        /// Hash of the patch's state.
        state_hash: u64,
        /// Largest stack use so far [bytes].
        stack_used_bytes: u32,
        /// Frames that were dropped.
        bad_frames: u32,
        /// Nodes of the patch.
        nodes: u32,
    },
    /// The answer to [`ToBoard::Identify`].
    Identity(Identity),
    /// The home pose is taken.
    Homed,
    /// A piece of the log, between two records.
    Log(Log),
    /// The answer to [`ToBoard::YoungsModulus`] under force: this one [Pa] was taken.
    Modulus(f32),
}

/// Longest name of a board with its image's version [bytes].
pub const NAME_BYTES: usize = 32;

/// Board, image and patch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// Board and version of the image in ASCII, separated by a space and padded with zeros.
    pub name: [u8; NAME_BYTES],
    /// Day on which the image was built, counted from 1970-01-01; 0 is unknown.
    pub built_day: u16,
    /// Counts per second of the clock that [`Record::spent_counts`] is in.
    pub clock_hz: u32,
    /// Checksum of the patch file; 0 while there is no patch.
    pub patch_checksum: u32,
    /// Young's modulus of the patch [Pa]; 0 while there is no patch.
    pub youngs_modulus_pa: f32,
    /// Checksum of the image's sources and features, which its ELF file holds too. It identifies
    /// the image whose log this is. 0 is unknown.
    pub image: u32,
}

impl Identity {
    /// Creates the identity of a board with a patch of this checksum and Young's modulus [Pa].
    #[must_use]
    pub fn new(about: &About, (patch_checksum, youngs_modulus_pa): (u32, f32)) -> Self {
        let mut name = [0; NAME_BYTES];
        name.iter_mut().zip(about.name.bytes()).for_each(|(place, byte)| *place = byte);
        Self { name, built_day: about.built_day, clock_hz: about.clock_hz, patch_checksum, youngs_modulus_pa, image: about.image }
    }
}

/// Why a request was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum Refusal {
    /// Patches and profiles are accepted in `Idle` only, a parameter also under force.
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
    /// The patch needs a shorter step than the board makes.
    PatchStep,
    /// The mesh or the parameters of the patch are wrong.
    PatchInvalid,
    /// There is no patch yet.
    NoPatch,
    /// A number of the profile is out of its range.
    ProfileRange,
    /// The profile memory cannot store the profile.
    FlashFailed,
    /// A tick of the patch costs more than the board's budget.
    PatchCost,
    /// The site, the axis or the depth limit of the patch does not lie on its own surface.
    PatchSite,
    /// The probe of the patch is a capsule or an ellipsoid, which the image leaves out.
    PatchTip,
    /// The mechanism of the profile is impossible, or cannot move like that.
    Mechanism(MechanismError),
    /// The device has not been homed since power-on, or its encoders failed since.
    NotHomed,
    /// The device's joints have no encoders.
    NoEncoders,
    /// Crashes came too often: only power-on or the reset button lets it arm again.
    Barred,
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
            Self::NotHomed => "the home pose is not known: hold the device in it and run `palpate board home`",
            Self::NoEncoders => "no encoder of this board answers: check the wiring, or send the board its readings",
            Self::Barred => {
                "the board crashed three times within a minute and arms no more: switch it off and on, and see its log for the cause"
            }
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

impl core::error::Error for Refusal {}
