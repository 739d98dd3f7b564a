//! Messages of the link.

use core::fmt;

use palpate::haptic::cycle::Ask;
use serde::{Deserialize, Serialize};

use super::contact::{TooNarrow, TooStiff};
use super::log::Log;
use super::record::Record;
use super::wire_limits::WireLimits;
use crate::about::About;
use crate::commission::{Progress, Setup, WireResult};
use crate::config::{Profile, ProfileError, StoreError};
use crate::kinematics::MechanismError;

/// Messages from the host. Each of them counts as a keep-alive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ToBoard<'a> {
    /// A keep-alive without further content.
    Heartbeat,
    /// A tip position in place of the board's own sensors; completes the input of a lock-step tick.
    Pose {
        /// Tip position [m], device frame.
        position_m: [f32; 3],
        /// Number of the reading.
        sequence: u32,
        /// False if the sensor reports that its reading cannot be trusted.
        good: bool,
    },
    /// A request to the mode machine.
    Ask(HostAsk),
    /// Lower the limits; accepted in any mode.
    LowerLimits(WireLimits),
    /// Another Young's modulus [Pa], between half and twice that of the patch as it was packed. In
    /// `Idle` the patch is restarted at rest with it. In the modes with force a decrease applies at
    /// once, an increase as soon as the probe does not touch.
    YoungsModulus(f32),
    /// Announces a patch of this many bytes; accepted in `Idle`.
    PatchBegin(u32),
    /// A piece of the patch; pieces arrive in order.
    PatchPart {
        /// Bytes of the patch before this piece.
        at: u32,
        /// Content of the piece.
        #[serde(borrow)]
        bytes: &'a [u8],
    },
    /// The patch is complete.
    PatchEnd,
    /// Request the state; the answer is [`FromBoard::State`].
    Report,
    /// Store a profile permanently and restart the controller with it; accepted in `Idle`.
    Store(Profile),
    /// The actuators' supply voltage is too low; for boards that cannot measure it themselves.
    SupplyLow,
    /// The stop circuit is open; for boards that are not connected to it.
    EmergencyStop,
    /// Whether the operator's switch is pressed, for boards without a pin for one. Valid until the
    /// next such message; before the first one the switch counts as released.
    Operator(bool),
    /// Request the board's identity; the answer is [`FromBoard::Identity`].
    Identify,
    /// Encoder counts in place of the board's own; otherwise like [`Self::Pose`].
    Joints {
        /// One count per joint, in the mechanism's order.
        counts: [i32; 3],
        /// Number of the reading.
        sequence: u32,
        /// False if the encoders report that their counts cannot be trusted.
        good: bool,
    },
    /// Take the present pose as the home pose; accepted in `Idle`.
    Home,
    /// Whether the host reads the log; true is valid for the next [`crate::serve::LISTENS_TICKS`]
    /// ticks.
    Listen(bool),
    /// Begin a commissioning, in `Idle`. From then on the board sends
    /// [`FromBoard::Commissioning`] with every record.
    Commission(Setup),
    /// The user confirms the step of the commissioning that the board waits for.
    Confirm,
}

/// Requests of a host to the mode machine; the requests of start-up come from the board itself.
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

/// Messages from the board.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum FromBoard {
    /// Record of a tick.
    Record(Record),
    /// A request was not carried out.
    Refused(Refusal),
    /// A patch of this many nodes is ready, at rest.
    PatchTaken(u32),
    /// The profile is in use and stored under this generation number; 0 if the board cannot store
    /// it, so that it is valid until power-off.
    Stored(u32),
    /// The answer to [`ToBoard::Report`].
    State {
        /// Hash of all node positions and velocities.
        state_hash: u64,
        /// Largest stack use so far [bytes].
        stack_used_bytes: u32,
        /// Number of received frames that were dropped.
        bad_frames: u32,
        /// Number of nodes of the patch; 0 while there is no patch.
        nodes: u32,
        /// Whether the device was commissioned.
        commissioned: bool,
        /// Energy that the device can give the hand at once [J].
        at_once_j: f32,
        /// Energy that it can give for as long as it runs [W].
        lasting_w: f32,
    },
    /// The answer to [`ToBoard::Identify`].
    Identity(Identity),
    /// The home pose has been recorded.
    Homed,
    /// A piece of the log, between two records.
    Log(Log),
    /// The answer to [`ToBoard::YoungsModulus`] in a mode with force: the modulus [Pa] that was
    /// accepted.
    Modulus(f32),
    /// Step of the commissioning.
    Commissioning(Progress),
    /// Result of the commissioning. The profile is still the old one: the host completes it and
    /// sends it with [`ToBoard::Store`].
    Commissioned(WireResult),
}

/// Longest name of a board with its image's version [bytes].
pub const NAME_BYTES: usize = 32;

/// Identification of board, image and patch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// Board and version of the image in ASCII, separated by a space and padded with zeros.
    pub name: [u8; NAME_BYTES],
    /// Day on which the image was built, counted from 1970-01-01; 0 if unknown.
    pub built_day: u16,
    /// Frequency of the clock that [`Record::spent_counts`] counts [Hz].
    pub clock_hz: u32,
    /// Checksum of the patch file; 0 while there is no patch.
    pub patch_checksum: u32,
    /// Young's modulus of the patch [Pa]; 0 while there is no patch.
    pub youngs_modulus_pa: f32,
    /// Checksum of the image's sources and features, which its ELF file contains too: hosts find
    /// the file that decodes the log by it. 0 if unknown.
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

impl core::error::Error for Refusal {}
