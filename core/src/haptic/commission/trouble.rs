//! Why a commissioning ended without a result.

use core::fmt;

/// Names of the axes in messages.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Reason why a commissioning stopped. The profile stays as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// The user, the host or the board ended it.
    Interrupted,
    /// A fault is latched, or the readings cannot be trusted.
    Faulted,
    /// No reading changed enough while the user should have moved the handle along this axis.
    NotMoved(u8),
    /// Two readings changed alike while the user moved the handle along this axis.
    Slanted(u8),
    /// The reading that changed along this axis already belongs to another axis.
    SameSensor(u8),
    /// The handle moves although no motor drives it.
    Moving,
    /// This motor does not move the handle with the largest force that is tried.
    Stuck(u8),
    /// The handle sprang back when the force of this motor ended.
    Held(u8),
    /// The handle moved differently each time that this motor drove it.
    Unsteady(u8),
    /// This motor drives two axes alike.
    TwoAxes(u8),
    /// This motor drives an axis that another motor drives too.
    SameMotor(u8),
    /// The handle went too far from where it was let go.
    TooFar,
    /// The answer of the handle was too short or too coarse to find delay and lag.
    Unclear,
}

impl Trouble {
    /// Number on the link, with the axis or motor: see [`Self::of_number`].
    #[must_use]
    #[inline]
    pub fn number(self) -> u8 {
        match self {
            Self::Interrupted => 1,
            Self::Faulted => 2,
            Self::Moving => 3,
            Self::TooFar => 4,
            Self::Unclear => 5,
            Self::NotMoved(axis) => 8 + axis,
            Self::Slanted(axis) => 12 + axis,
            Self::SameSensor(axis) => 16 + axis,
            Self::Stuck(motor) => 20 + motor,
            Self::Held(motor) => 24 + motor,
            Self::Unsteady(motor) => 28 + motor,
            Self::TwoAxes(motor) => 32 + motor,
            Self::SameMotor(motor) => 36 + motor,
        }
    }

    /// The reason with this number, if there is one.
    #[must_use]
    #[inline]
    pub fn of_number(number: u8) -> Option<Self> {
        let plain = [Self::Interrupted, Self::Faulted, Self::Moving, Self::TooFar, Self::Unclear];
        let of: [fn(u8) -> Self; 8] = [
            Self::NotMoved,
            Self::Slanted,
            Self::SameSensor,
            Self::Stuck,
            Self::Held,
            Self::Unsteady,
            Self::TwoAxes,
            Self::SameMotor,
        ];
        let numbered = of.into_iter().flat_map(|reason| [0, 1, 2].map(reason));
        plain.into_iter().chain(numbered).find(|reason| reason.number() == number)
    }
}

impl fmt::Display for Trouble {
    #[inline]
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axis = |axis: &u8| AXES.get(usize::from(*axis)).copied().unwrap_or("?");
        match self {
            Self::Interrupted => f.write_str("it was interrupted: begin again"),
            Self::Faulted => f.write_str("a fault came or a reading cannot be trusted: see to the cause, then begin again"),
            Self::NotMoved(n) => write!(
                f,
                "no reading changed by more than 20 counts along {}: move the handle by the stated distance; if it did move, check the encoders' wires",
                axis(n)
            ),
            Self::Slanted(n) => {
                write!(f, "two readings changed alike along {}: move the handle along that axis alone, straight", axis(n))
            }
            Self::SameSensor(n) => write!(
                f,
                "the reading that changed along {} is already that of another axis: move the handle along the axis that is asked for",
                axis(n)
            ),
            Self::Moving => {
                f.write_str("the handle moves although no motor drives it: take the hand off, and support a handle that sinks")
            }
            Self::Stuck(n) => write!(
                f,
                "motor {} does not move the handle with 0.5 N: take the hand off, check that the motors have power and the handle is free",
                n + 1
            ),
            Self::Held(n) => {
                write!(f, "the handle sprang back after the push of motor {}: take the hand off, nothing may hold it", n + 1)
            }
            Self::Unsteady(n) => write!(
                f,
                "the handle answered motor {} differently each time: take the hand off, and let no cable drag",
                n + 1
            ),
            Self::TwoAxes(n) => {
                write!(f, "motor {} drives two axes alike: the stated axes are not those of the motors", n + 1)
            }
            Self::SameMotor(n) => write!(f, "motor {} drives an axis that another motor drives: check the motors' wires", n + 1),
            Self::TooFar => f.write_str(
                "the handle went more than 60 mm from where it was let go: put it into the middle of the workspace, level, and begin again",
            ),
            Self::Unclear => f.write_str("the answer of the handle is too short to find delay and lag: free the handle, or use finer encoders"),
        }
    }
}
