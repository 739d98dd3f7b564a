//! Faults as data, and their injection: around a device ([`Faulty`]), around a tissue
//! ([`FaultyTissue`]), and into the host's messages.
//!
//! An [`Injection`] begins at a tick and lasts for a number of ticks. Everything else is the loop
//! as it ships: nothing in the core knows about the injection.

mod device;
pub mod list;
mod tissue;

pub use device::Faulty;
pub use tissue::FaultyTissue;

use palpate::Fault;
use palpate::haptic::cycle::Ask;

/// Fault in a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// One coordinate has this value [m].
    Is(f32),
    /// Displaced by this much along the normal and sideways [m].
    Shifted {
        /// Displacement out of the tissue [m].
        out_m: f32,
        /// Displacement along the surface [m].
        aside_m: f32,
    },
    /// The last reading again, with its sequence number.
    Repeated,
    /// The sequence number is behind by this many; the position is new.
    Behind(u32),
    /// The sensor reports that it failed.
    Failed,
    /// The sequence numbers advance, but the position stays the same.
    Stuck,
    /// The sequence numbers advance, but one coordinate stays the same.
    Frozen,
    /// Every coordinate, relative to the site, has the wrong sign.
    Mirrored,
    /// One coordinate, relative to the site, has the wrong sign.
    MirroredAxis,
    /// Noise of up to this many counts in either direction is added to every coordinate.
    Noise(u8),
    /// The position of this many ticks ago.
    Late(usize),
    /// In one tick out of four, at random, the position of the previous tick.
    Jitter,
    /// Sequence numbers jump so far that they wrap every 16 readings.
    Wraps,
}

/// Fault in a force on its way to the hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ForceFault {
    /// The force on each axis saturates at this value [N].
    Saturated(f32),
    /// The last force remains, whatever is commanded; a release still removes the power.
    Stuck,
    /// The force is multiplied by this factor (1); a negative factor reverses it.
    Scaled(f32),
    /// The force is delayed by this many ticks.
    Late(usize),
    /// No force is output.
    Dropped,
    /// The amplifier has this time constant [s].
    Lag(f64),
    /// Friction is multiplied by this factor (1).
    Friction(f64),
}

/// Injected behaviour of a host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Host {
    /// The host sends nothing.
    Silent,
    /// The host makes this request in every tick.
    Asks(Ask),
    /// The host halves the maximum force while the loop runs.
    Lowers,
    /// The host requests a change that must be refused: 0 raises the maximum force, 1 sets it to
    /// NaN, 2 raises the slew limit, and any other number makes the speed limit negative.
    Raises(u8),
}

/// Fault in the tissue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TissueFault {
    /// The node under the probe moves with this speed along every axis [m/s].
    NodeSpeed(f32),
    /// Every coordinate of the node under the probe has this value [m].
    NodeAt(f32),
    /// Every node's velocity has this value [m/s], a denormal number.
    Denormal(f32),
    /// The force has this magnitude along the normal [N], with or without contact.
    Force(f32),
    /// A sideways component is added to the force [N], and the normal turns with the force.
    Aside(f32),
    /// The force is multiplied by this factor (1).
    Scaled(f32),
    /// The force is larger by this much during retreat than during approach [N], so the tissue
    /// creates energy.
    Active(f32),
}

/// Fault to inject, by the place where it enters the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Injection {
    /// No fault is injected: in these runs no check may trip.
    None,
    /// Fault in the readings.
    Reading(Reading),
    /// Fault in the forces.
    ForceFault(ForceFault),
    /// Fault in the host's messages.
    Host(Host),
    /// Periods are missed at regular intervals.
    Late {
        /// Number of periods that are missed each time.
        ticks: u16,
        /// Interval between late ticks [ticks].
        every: u32,
    },
    /// The board reports this fault.
    Found(Fault),
    /// Fault in the tissue.
    Tissue(TissueFault),
}

impl Injection {
    /// Whether device and board are still what the profile says: a bound on energy that follows
    /// from the profile holds only then.
    pub fn keeps_profile(self) -> bool {
        !matches!(self, Self::Reading(_) | Self::ForceFault(_) | Self::Late { ticks: 2.., .. })
    }
}

/// State of loop and probe at the start of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opening {
    /// The loop is armed and ramped in, and the probe is outside.
    Active,
    /// The loop is powered on with the probe in the tissue.
    Inside,
    /// The probe is waved about while the loop arms.
    Waving,
    /// The probe touches the tissue while the gain still ramps in.
    RampingIn,
}

/// Condition that must hold when the fault begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// The fault may begin at any time.
    Nothing,
    /// A force above 0.3 N acts.
    Force,
    /// A force acts, and the probe moves faster than 0.35 m/s: a fast tap.
    FastForce,
    /// A force above 0.3 N acts on a device that nobody holds.
    NobodysForce,
}

/// Reaction required of the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// The loop removes the force within this many ticks, and latches one of these faults.
    Fault(&'static [Fault], u32),
    /// The loop continues as if nothing had happened.
    Ridden,
    /// The fault cannot be distinguished from a hand with certainty: the loop latches one of these
    /// faults, or none, and the force always stays within its limits.
    Bounded(&'static [Fault]),
    /// The force begins to ramp down within this many ticks, and is at most 0.05 N after 150 ticks.
    Ramp(u32),
    /// The force remains, but is scaled down within this many ticks.
    Degraded(u32),
    /// No force at any time.
    Nothing,
}

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultType {
    /// Number from the list of hazards, with a variant after a dash.
    pub id: &'static str,
    /// Description of the fault, such as `encoder stuck for 100 ms`.
    pub name: &'static str,
    /// State of loop and probe at the start of the run.
    pub opening: Opening,
    /// Fault to inject.
    pub injection: Injection,
    /// Duration in ticks.
    pub ticks: u32,
    /// Condition under which the fault may begin.
    pub needs: Needs,
    /// Reaction that the loop has to show in time.
    pub expected: Expected,
}
