//! Messages of the link.

use palpate::haptic::cycle::Ask;
use serde::{Deserialize, Serialize};

use super::log::Log;
use super::record::Record;
use crate::about::About;
use crate::commission::{Progress, Setup, WireResult};
use crate::config::Profile;
use crate::crash::Crash;
use crate::refusal::Refusal;
use crate::wire_limits::WireLimits;

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
    /// The last crash since power-on, after the answer to [`ToBoard::Report`].
    Crashed(Crash),
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
    /// Predicted cycles of the patch's costliest tick on a Cortex-M4F without wait states.
    pub predicted_cycles: f32,
    /// Longest tick to be expected, as [`crate::haptic_loop::HapticLoop::longest_counts`] has
    /// measured it [counts]; 0 before a patch was opened.
    pub longest_counts: u32,
    /// Checksum of the image's sources and features, which its ELF file contains too: hosts find
    /// the file that decodes the log by it. 0 if unknown.
    pub image: u32,
}

impl Identity {
    /// Creates the identity of a board with a patch of this checksum, Young's modulus [Pa] and
    /// predicted cycles, and with this longest tick [counts].
    #[must_use]
    pub fn new(
        about: &About,
        (patch_checksum, youngs_modulus_pa, predicted_cycles): (u32, f32, f32),
        longest_counts: u32,
    ) -> Self {
        let mut name = [0; NAME_BYTES];
        name.iter_mut().zip(about.name.bytes()).for_each(|(place, byte)| *place = byte);
        Self {
            name,
            built_day: about.built_day,
            clock_hz: about.clock_hz,
            patch_checksum,
            youngs_modulus_pa,
            predicted_cycles,
            longest_counts,
            image: about.image,
        }
    }
}

impl core::error::Error for Refusal {}
