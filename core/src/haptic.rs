//! The haptic loop, from a sensed pose to a force on the hand. Board and desktop run the same code.
//!
//! ```text
//! sense ─ pose ─ toggle ─ tick ─ apart ─ shorten ─ damping ─ gains ─ limits ─ actuate
//!         fresh, mean of  the    at the  to the    tangent,  ramp-in, norm,
//!         likely two      patch  tissue? limit     in        relief  slew
//!                counts                            contact
//! ceiling: one gain for a contact that is stiffer than the device renders
//! mode: decides whether force output is enabled
//! passivity: energy given to the hand, always watched
//! runaway, stillness: detect a reversed force, or a dead encoder
//! ```
//!
//! [`cycle::Cycle::tick`] runs these stages in order. None of them allocates or panics. Any fault
//! gives zero force within the same tick and is latched and numbered ([`crate::Fault`]). Limits
//! apply from the first tick; they can be lowered, never raised or switched off. Depth and speed of
//! the tip that the *patch* is given are limited by the patch's own guard,
//! [`crate::stages::probe`].

pub mod account;
pub mod apart;
pub mod ceiling;
pub mod commission;
pub mod cycle;
pub mod damping;
pub mod deadline;
pub mod device;
pub mod gains;
pub mod limits;
pub mod mode;
pub mod runaway;
pub mod seen;
pub mod stillness;
pub mod toggle;

use nalgebra::Vector3;

use crate::fault::BuildError;
use crate::lanes::sqrt;

/// Euclidean length; infinite or NaN if a component or its square is.
#[inline(always)]
pub(crate) fn length(v: &Vector3<f32>) -> f32 {
    sqrt(v.dot(v))
}

/// Clamps `x` to two bounds. `f32::clamp` panics if the bounds cross, and the code for its message
/// costs 25 KB of flash.
#[inline(always)]
pub(crate) fn between(x: f32, low: f32, high: f32) -> f32 {
    if x < low {
        low
    } else if x > high {
        high
    } else {
        x
    }
}

/// Name of a value with its smallest and largest permitted values.
pub(crate) type Range = (&'static str, f32, f32);

/// Returns an error that names the first value outside its range. The ranges are passed as data: as
/// code they would cost the board some 400 bytes more.
pub(crate) fn each_within<const N: usize>(ranges: &'static [Range; N], values: [f32; N]) -> Result<(), BuildError> {
    ranges.iter().zip(values).try_for_each(|(&(parameter, min, max), value)| BuildError::within(parameter, value, min, max))
}

/// Returns an error that names the first value outside its range: (name, value, smallest, largest).
pub(crate) fn within(ranges: &[(&'static str, f32, f32, f32)]) -> Result<(), BuildError> {
    ranges.iter().try_for_each(|&(parameter, value, min, max)| BuildError::within(parameter, value, min, max))
}
