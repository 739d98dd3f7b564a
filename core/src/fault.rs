//! Errors and flags: build errors name the item, run-time faults are numbered and latched, and
//! limiter flags show what was clamped.

use core::fmt;

/// Reason why a model or a set of parameters cannot run. It is found before the first tick, never
/// during one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BuildError {
    /// No node or no tet.
    Empty,
    /// An item names a node that does not exist.
    NodeOutOfRange {
        /// Kind of item.
        item: &'static str,
        /// Index of the item.
        index: usize,
        /// The node that the item names.
        node: u16,
    },
    /// A number is NaN or infinite.
    NotFinite {
        /// Kind of item or name of the parameter.
        item: &'static str,
        /// Index of the item (0 for a parameter).
        index: usize,
    },
    /// A number that must be positive is not.
    NotPositive {
        /// Kind of item.
        item: &'static str,
        /// Index of the item.
        index: usize,
    },
    /// An item joins a node to itself, is out of order, or contradicts the items next to it.
    Degenerate {
        /// Kind of item.
        item: &'static str,
        /// Index of the item.
        index: usize,
    },
    /// Two lists that belong together differ in length.
    LengthMismatch {
        /// Name of the list.
        item: &'static str,
        /// Length that fits the model.
        need: usize,
        /// Length of the list.
        have: usize,
    },
    /// More items than the reserved memory or the index type holds.
    TooLarge {
        /// Name of the list.
        item: &'static str,
        /// Items in the model.
        need: usize,
        /// Items that fit.
        have: usize,
    },
    /// A parameter outside its range.
    OutOfRange {
        /// Name of the parameter, with its unit.
        parameter: &'static str,
        /// Value that was given.
        value: f32,
        /// Smallest value allowed.
        min: f32,
        /// Largest value allowed.
        max: f32,
    },
    /// The patch was built for another Poisson's ratio, which determines the springs and so cannot
    /// be set afterwards.
    PoissonMismatch {
        /// Poisson's ratio that was given.
        given: f32,
        /// Value that the patch was built for.
        patch: f32,
    },
    /// The bytes are not a patch file of this version.
    NotAPatch,
    /// The patch file's checksum does not match: the file was truncated or changed.
    Checksum {
        /// CRC-32 in the header.
        expected: u32,
        /// CRC-32 of the content.
        found: u32,
    },
    /// The patch file's bytes do not start on a 4-byte boundary.
    Misaligned,
    /// The patch file's reserved word is not zero.
    ReservedWord {
        /// Bits of the word.
        found: u32,
    },
    /// The probe is a capsule or an ellipsoid, which this build leaves out: its feature `long-tips`
    /// is off.
    NoSuchTip,
}

impl BuildError {
    /// Checks a parameter against its range; NaN is outside every range.
    ///
    /// # Errors
    /// [`Self::OutOfRange`], if `value` is not between `min` and `max`.
    pub fn within(parameter: &'static str, value: f32, min: f32, max: f32) -> Result<(), Self> {
        if min <= value && value <= max { Ok(()) } else { Err(Self::OutOfRange { parameter, value, min, max }) }
    }
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Empty => write!(f, "the model has no node or no tet: check the mesh"),
            Self::NodeOutOfRange { item, index, node } => {
                write!(f, "{item} {index} names node {node}, which does not exist: check the mesh or pack it again")
            }
            Self::NotFinite { item, index } => write!(f, "{item} {index} is NaN or infinite: give a finite number"),
            Self::NotPositive { item, index } => write!(f, "{item} {index} must be above zero and finite"),
            Self::Degenerate { item, index } => write!(f, "{item} {index} is degenerate or misplaced: pack the patch again"),
            Self::LengthMismatch { item, need, have } => write!(f, "{item}: {have} entries where the model needs {need}"),
            Self::TooLarge { item, need, have } => write!(f, "{item}: the model has {need}, {have} fit: take a smaller mesh"),
            Self::OutOfRange { parameter, value, min: f32::MIN_POSITIVE, max } => {
                write!(f, "{parameter} = {value} must be above zero and at most {max}: choose a value in that range")
            }
            Self::OutOfRange { parameter, value, min, max } => {
                write!(f, "{parameter} = {value} is outside {min} .. {max}: choose a value in that range")
            }
            Self::PoissonMismatch { given, patch } => {
                write!(f, "poisson_ratio = {given}, but the patch was built for {patch}: pack it again with the new value")
            }
            Self::NotAPatch => write!(f, "not a patch file of this version: pack it again"),
            Self::Checksum { expected, found } => {
                write!(f, "patch checksum {found:08x} is not {expected:08x}: the file is damaged, pack it again")
            }
            Self::ReservedWord { found } => {
                write!(f, "the patch has {found:08x} in a reserved word, which must be zero: pack it again")
            }
            Self::NoSuchTip => {
                write!(
                    f,
                    "the probe is a capsule or an ellipsoid, which this build leaves out: take a hemisphere, sphere or flat"
                )
            }
            Self::Misaligned => write!(f, "the patch does not start on a 4-byte boundary: align the buffer"),
        }
    }
}

impl core::error::Error for BuildError {}

/// Reason why the force is zero. It stays latched: in a patch until [`crate::State::reset`], in a
/// haptic loop until it is cleared by request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[non_exhaustive]
pub enum Fault {
    /// The probe pose was NaN or infinite.
    PoseNotFinite = 1,
    /// A node moved faster than any tissue can: the integration diverged.
    Diverged = 2,
    /// The contact force came out NaN or infinite.
    ForceNotFinite = 3,
    /// State, parameters and model differ in size.
    SizeMismatch = 4,
    /// The device reported that its sensor cannot be trusted, or its readings showed it.
    SensorFault = 5,
    /// The last new pose is older than allowed, or too many poses were missing.
    PoseStale = 6,
    /// The pose was outside the workspace and its margin.
    OutOfWorkspace = 7,
    /// The probe moved faster than a hand can while a force acted on it.
    OverSpeed = 8,
    /// The model asked for a force far beyond the limit for many ticks.
    ForceImplausible = 9,
    /// The hand was given more energy than any motion of a hand explains: the device is not what
    /// its profile says.
    EnergyCreated = 10,
    /// The self-test did not pass.
    SelfTestFailed = 11,
    /// Ticks ended too late, or those of the patch are too long to arm.
    DeadlineMissed = 12,
    /// The supply fell below what the actuators need.
    SupplyLow = 13,
    /// The probe sped up against a force that should have slowed it down.
    Runaway = 14,
    /// A force acted on a tip that was outside the tissue, or the patch was given a tip position
    /// other than the sensed one.
    TipApart = 15,
    // 16 is retired: a wrong unit is found by commissioning
    /// The emergency stop was pressed, its wire is open, or the over-current trip acted.
    EmergencyStop = 17,
    // 18 is retired: a wrong sign is found by commissioning
}

impl Fault {
    /// All faults, in the order of their numbers.
    pub const ALL: [Self; 16] = [
        Self::PoseNotFinite,
        Self::Diverged,
        Self::ForceNotFinite,
        Self::SizeMismatch,
        Self::SensorFault,
        Self::PoseStale,
        Self::OutOfWorkspace,
        Self::OverSpeed,
        Self::ForceImplausible,
        Self::EnergyCreated,
        Self::SelfTestFailed,
        Self::DeadlineMissed,
        Self::SupplyLow,
        Self::Runaway,
        Self::TipApart,
        Self::EmergencyStop,
    ];

    /// Short description of the fault, in lower case.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::PoseNotFinite => "the probe pose was not finite",
            Self::Diverged => "the tissue diverged",
            Self::ForceNotFinite => "the force was not finite",
            Self::SizeMismatch => "state, parameters and model differ in size",
            Self::SensorFault => "the device's sensor cannot be trusted",
            Self::PoseStale => "no new pose came, or too few",
            Self::OutOfWorkspace => "the pose was outside the workspace",
            Self::OverSpeed => "the probe moved too fast under force",
            Self::ForceImplausible => "the model's force was implausible",
            Self::EnergyCreated => "the loop created energy",
            Self::SelfTestFailed => "the self-test failed",
            Self::DeadlineMissed => "ticks ended too late",
            Self::SupplyLow => "the supply was too low",
            Self::Runaway => "the probe ran away against the force",
            Self::TipApart => "a force acted on a probe that was not at the tissue",
            Self::EmergencyStop => "the emergency stop or the over-current trip acted",
        }
    }

    /// Advice on how to remove the cause, if it is in the set-up of the device.
    #[must_use]
    pub fn remedy(self) -> Option<&'static str> {
        match self {
            Self::OutOfWorkspace => Some("check the unit and the frame of the readings, and the profile's workspace"),
            Self::DeadlineMissed => Some("take a smaller patch, see `palpate board status` for its longest tick"),
            Self::Runaway => Some("commission the device again: a sign may have changed"),
            _ => None,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fault {}: {}", *self as u8, self.text())?;
        self.remedy().map_or(Ok(()), |remedy| write!(f, ": {remedy}"))
    }
}

/// Flags for quantities that were clamped in a tick. Clamping is not a fault: the force is right
/// for the clamped values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClampFlags(u8);

impl ClampFlags {
    /// Nothing was clamped.
    pub const DEFAULT: Self = Self(0);
    /// The probe moved faster than `max_speed_m_per_s`, or into the tissue faster than
    /// `max_sink_m_per_s`; the patch was shown a probe that moves at that limit.
    pub const SPEED: Self = Self(1);
    /// The probe was deeper than the patch's depth limit, or beyond the places of its law, and was
    /// clamped to it; or it pressed more triangles than a tick has time for.
    pub const DEPTH: Self = Self(2);
    /// The force was larger than `max_force_n`; its magnitude was clamped, its direction kept.
    pub const FORCE: Self = Self(4);

    /// The probe began inside the tissue, or the surface closed over it: there is no force until it
    /// has been outside once.
    pub const BURIED: Self = Self(8);
    /// The force on the hand was limited by the slew rate.
    pub const SLEW: Self = Self(16);
    /// An older pose was rendered, because the newest was missing or a glitch.
    pub const HELD: Self = Self(32);
    /// The force was scaled down: ramp-in, relief after saturation, or an encoder that no longer
    /// counts.
    pub const GAIN: Self = Self(64);
    /// The force was scaled down because the contact gave energy to the hand, or would have given
    /// it within the delay of the loop.
    pub const ENERGY: Self = Self(128);

    /// Sets all flags of `other` and keeps those already set.
    pub fn set(&mut self, other: Self) {
        self.0 |= other.0;
    }

    /// True if all flags of `other` are set.
    #[must_use]
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The flags as a byte, for telemetry.
    #[must_use]
    pub fn bits(self) -> u8 {
        self.0
    }
}
