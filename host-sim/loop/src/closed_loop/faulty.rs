//! Faults as data, and their injection: around a device ([`Faulty`]), around a tissue
//! ([`FaultyTissue`]), into the host's messages.
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
    /// A coordinate has this value.
    Is(f32),
    /// Displaced by this much along the normal and sideways [m].
    Shifted {
        /// Out of the tissue.
        out_m: f32,
        /// Along the surface.
        aside_m: f32,
    },
    /// The last reading again, with its number.
    Repeated,
    /// The sequence number is behind by this many; the position is new.
    Behind(u32),
    /// The sensor says that it failed.
    Failed,
    /// New sequence numbers, always the same position.
    Stuck,
    /// New sequence numbers, always the same position along one axis.
    Frozen,
    /// Every coordinate, counted from the site, has the wrong sign.
    Mirrored,
    /// One has.
    MirroredAxis,
    /// Random counts are added, up to this many.
    Noise(u8),
    /// The position of this many ticks ago.
    Late(usize),
    /// Occasionally the position of the previous tick.
    Jitter,
    /// Sequence numbers jump so far that they wrap every 16 readings.
    Wraps,
}

/// Fault in a force on its way to the hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ForceFault {
    /// The force on each axis saturates at this value [N].
    Saturated(f32),
    /// The last force stays, whatever is commanded; a release still removes the power.
    Stuck,
    /// The force times this factor (1); below zero the sign is wrong.
    Scaled(f32),
    /// Late by this many ticks.
    Late(usize),
    /// No force is output.
    Dropped,
    /// The amplifier has this time constant [s].
    Lag(f64),
    /// Friction is multiplied by this (1).
    Friction(f64),
}

/// Injected behaviour of a host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Host {
    /// The host sends nothing.
    Silent,
    /// The host makes this request in every tick.
    Asks(Ask),
    /// The host halves the maximum force, in place.
    Lowers,
    /// The host tries to raise this limit, or to set it to NaN.
    Raises(u8),
}

/// Fault in the tissue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TissueFault {
    /// A node moves with this speed along every axis [m/s].
    NodeSpeed(f32),
    /// Every coordinate of a node has this value [m].
    NodeAt(f32),
    /// Every node's velocity has this value [m/s], a denormal number.
    Denormal(f32),
    /// The force along the normal has this length [N], with or without contact.
    Force(f32),
    /// A sideways component of the force is this [N], and the normal turns with it.
    Aside(f32),
    /// The force is multiplied by this (1).
    Scaled(f32),
    /// It pushes harder by this much during retreat than during approach [N]: it creates energy.
    Active(f32),
}

/// Fault to inject, by the place where it enters the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Injection {
    /// No fault is planted: in these runs nothing may trip.
    None,
    /// Into the readings.
    Reading(Reading),
    /// Into the forces.
    ForceFault(ForceFault),
    /// Into the host's messages.
    Host(Host),
    /// A number of periods is missed, at intervals of a number of ticks.
    Late {
        /// Periods without a force.
        ticks: u16,
        /// Interval between late ticks.
        every: u32,
    },
    /// The board reports this fault.
    Found(Fault),
    /// Into the tissue.
    Tissue(TissueFault),
}

/// Opening of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opening {
    /// The loop is armed and ramped in, and the probe is outside.
    Active,
    /// Power comes on with the probe in the tissue.
    Inside,
    /// The probe is waved about while the loop arms.
    Waving,
    /// Touched while the gain still ramps in.
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
    /// A force acts on a device that is not held.
    NobodysForce,
}

/// Reaction required of the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// No force within this many ticks, for one of these reasons.
    Fault(&'static [Fault], u32),
    /// Continue as if nothing had happened.
    Ridden,
    /// Cannot be distinguished from a hand with certainty: one of these faults, or none; the force
    /// always stays within its limits.
    Bounded(&'static [Fault]),
    /// A falling force from then on, and none above 0.05 N after 150 ticks.
    Ramp(u32),
    /// Felt, but scaled down within this many ticks.
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
    /// Opening of the run.
    pub opening: Opening,
    /// Fault to inject.
    pub injection: Injection,
    /// Duration in ticks.
    pub ticks: u32,
    /// Condition under which the fault may begin.
    pub needs: Needs,
    /// Required reaction.
    pub expected: Expected,
}
