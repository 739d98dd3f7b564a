//! Faults as data, and what injects them: around a device ([`Faulty`]), around a tissue
//! ([`FaultyTissue`]), into what the host says.
//!
//! An [`Injection`] begins at a tick and lasts for some. Everything else is the loop as it ships:
//! nothing in the core knows of this.

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
    /// A coordinate is this.
    Is(f32),
    /// Moved by so much along the normal and aside [m].
    Shifted {
        /// Out of the tissue.
        out_m: f32,
        /// Along the surface.
        aside_m: f32,
    },
    /// The last reading again, with its number.
    Repeated,
    /// Numbered behind by this many; the position is new.
    Behind(u32),
    /// The sensor says that it failed.
    Failed,
    /// Numbered on, always the same position.
    Stuck,
    /// Numbered on, always the same position along one axis.
    Frozen,
    /// Every coordinate, counted from the site, has the wrong sign.
    Mirrored,
    /// One has.
    MirroredAxis,
    /// Random counts are added, up to so many.
    Noise(u8),
    /// The position of so many ticks ago.
    Late(usize),
    /// Now and then the position of the tick before.
    Jitter,
    /// Numbers leap so far that they wrap every 16 readings.
    Wraps,
}

/// Fault in a force on its way to the hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// Each axis ends at this [N].
    Saturated(f32),
    /// The last force stays, whatever is asked; a release still takes the power off.
    Stuck,
    /// So many times what it should be (1); the wrong sign below zero.
    Scaled(f32),
    /// So many ticks late.
    Late(usize),
    /// Not given: no force.
    Dropped,
    /// The amplifier's time constant is this [s].
    Lag(f64),
    /// Friction is so many times what it was (1).
    Friction(f64),
}

/// Injected behaviour of a host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Host {
    /// Nothing at all.
    Silent,
    /// It asks this, every tick.
    Asks(Ask),
    /// It halves the maximum force, in place.
    Lowers,
    /// It raises a limit, or sets one that is no number; this one of them.
    Raises(u8),
}

/// Fault in the tissue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TissueFault {
    /// A node moves with this speed along every axis [m/s].
    NodeSpeed(f32),
    /// A node is at this place along every axis [m].
    NodeAt(f32),
    /// Every node's velocity is this small [m/s]: no normal number.
    Denormal(f32),
    /// The force is this long along the normal [N], touched or not.
    Force(f32),
    /// A sideways component of the force is this [N], and the normal goes with it.
    Aside(f32),
    /// The force is so many times what it was (1).
    Scaled(f32),
    /// It pushes this much harder on the way out than on the way in [N]: it makes energy.
    Active(f32),
}

/// Fault to inject, by the place where it enters the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Injection {
    /// Nothing: the runs that nothing may happen in.
    None,
    /// Into the readings.
    Reading(Reading),
    /// Into the forces.
    Drive(Drive),
    /// Into what the host says.
    Host(Host),
    /// A period is missed by so many, every so many ticks.
    Late {
        /// Periods without a force.
        ticks: u16,
        /// Distance of the late ticks.
        every: u32,
    },
    /// The board finds this.
    Found(Fault),
    /// Into the tissue.
    Tissue(TissueFault),
}

/// How a run begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opening {
    /// Armed and ramped in, outside.
    Active,
    /// Power comes on with the probe in the tissue.
    Inside,
    /// Somebody waves the probe about while it is to be armed.
    Waving,
    /// Touched while the gain still ramps in.
    RampingIn,
}

/// Condition that must hold when the fault begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// It may begin at any time.
    Nothing,
    /// A force above 0.3 N acts.
    Force,
    /// A force acts, and the probe moves faster than 0.35 m/s: a fast tap.
    FastForce,
    /// A force acts on a device that nobody holds.
    NobodysForce,
}

/// Reaction required of the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// No force within so many ticks, for one of these reasons.
    Fault(&'static [Fault], u32),
    /// Go on as if nothing had happened.
    Ridden,
    /// Cannot be distinguished from a hand for sure: one of these faults, or none; the force stays
    /// within its limits all the time.
    Bounded(&'static [Fault]),
    /// A falling force from here on, none above 0.05 N after 150 ticks.
    Ramp(u32),
    /// Felt, but scaled down within so many ticks.
    Degraded(u32),
    /// No force at all, ever.
    Nothing,
}

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultType {
    /// As in the list of hazards, a variant behind a dash.
    pub id: &'static str,
    /// Description of the fault, such as `encoder stuck for 100 ms`.
    pub name: &'static str,
    /// How the run begins.
    pub opening: Opening,
    /// Fault to inject.
    pub injection: Injection,
    /// For how many ticks.
    pub ticks: u32,
    /// When it may begin.
    pub needs: Needs,
    /// Required reaction.
    pub expected: Expected,
}
