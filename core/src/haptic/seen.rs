//! The interfaces of what judges a tick and of what shapes its force, and what both see.
//!
//! A [`Monitor`] can only end the force: it looks at the tick and reports a fault. A [`Shaper`]
//! changes the force. After damping no shaper may lengthen it (the test
//! `after_damping_no_shaper_lengthens_a_force`), so that the order of the shapers can be changed
//! without a new proof.

use nalgebra::Vector3;

use super::limits::LoopLimits;
use crate::fault::{ClampFlags, Fault};
use crate::stages::output::Output;

/// State of a tick when its force is judged and shaped.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Limits in effect.
    pub limits: &'a LoopLimits,
    /// Position read [m], and its displacement since the last tick [m].
    pub position_m: Vector3<f32>,
    /// See `position_m`.
    pub displacement_m: Vector3<f32>,
    /// One over the time since the last reading [1/s].
    pub per_s: f32,
    /// Position that the renderer was shown [m].
    pub shown_m: Vector3<f32>,
    /// Velocity of the shown position, low-passed [m/s].
    pub velocity_m_per_s: Vector3<f32>,
    /// Answer of the renderer; without contact where it did not run.
    pub output: Output,
    /// Stiffness of the contact along its normal [N/m].
    pub tangent_n_per_m: f32,
    /// Whether the renderer touched in this tick, and in the last one.
    pub touched: bool,
    /// See `touched`.
    pub was_touched: bool,
    /// Force sent in the last tick [N].
    pub sent_n: Vector3<f32>,
    /// Largest force that the mode and the deadline allow, and the limit after relief [N].
    pub cap_n: f32,
    /// See `cap_n`.
    pub relieved_n: f32,
}

impl<'a> Seen<'a> {
    /// A tick at rest, without contact and without a force.
    #[must_use]
    pub fn none(limits: &'a LoopLimits) -> Self {
        let zero = Vector3::zeros();
        let most_n = limits.values().max_force_n;
        Self {
            limits,
            position_m: zero,
            displacement_m: zero,
            per_s: limits.ticks_per_s(),
            shown_m: zero,
            velocity_m_per_s: zero,
            output: Output::NONE,
            tangent_n_per_m: 0.0,
            touched: false,
            was_touched: false,
            sent_n: zero,
            cap_n: most_n,
            relieved_n: most_n,
        }
    }
}

/// Judges a tick.
pub trait Monitor {
    /// Judges one tick; called once per tick, in every mode.
    ///
    /// # Errors
    /// The fault that ends the force.
    fn judge(&mut self, seen: &Seen) -> Result<(), Fault>;

    /// Returns to the state before the first tick, after a fault.
    fn reset(&mut self);
}

/// Shapes the force of a tick.
pub trait Shaper {
    /// Returns the force in place of `force_n` [N], and sets a flag if it differs.
    fn shape(&mut self, force_n: Vector3<f32>, seen: &Seen, flags: &mut ClampFlags) -> Vector3<f32>;

    /// Returns to the state before the first tick, after a fault.
    fn reset(&mut self);
}
