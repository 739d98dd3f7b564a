//! The haptic loop, from a sensed pose to a force on the hand. Board and desktop run the same code.
//!
//! ```text
//! sense     pose gate     fresh and likely, or the last one held, or a fault
//!           toggle        a count that flips is shown as its mean
//! render    tick          the patch's force; none outside the tissue
//!           ceiling       gain of a contact that is stiffer than the device renders
//! monitors  account       charges the work of the force that acted
//!           apart         force outside the tissue, or a shown tip that is not the sensed one
//!           plausible     force that is no number or absurd
//!           runaway       probe that gains speed against the force
//!           gains         force that stays at its limit
//!           stillness     strong force without a count
//! longest                 to the limit, before damping
//! damping                 in proportion to the tangent stiffness, in contact
//! shapers   gains         ramp-in after arming, relief at the limit
//!           stillness     fades
//!           slew          cap of mode and deadline, growth per tick, hardly any at rest
//!           account       no force that the balance does not pay for
//! actuate                 the force in modes that allow one, else release
//! ```
//!
//! [`cycle::Cycle::tick`] runs these stages in order. A monitor can only end the force, and none of
//! the shapers after damping lengthens it. No stage allocates or panics. Any fault gives zero force
//! within the same tick and is latched and numbered ([`crate::Fault`]). The mode
//! ([`mode::TRANSITIONS`]) decides whether there is a force at all, and [`deadline`] halves it
//! after a late tick. Limits apply from the first tick; they can be lowered, never raised or
//! switched off. Depth and speed of the tip that the *patch* is given are limited by the patch's
//! own guard, [`crate::stages::probe`]. Unit, sign and order of the axes are measured before the
//! loop runs, by [`commission`].
//!
//! The rules of the force path, each with its type or stage:
//!
//! 1. [`limits::PoseGate`]: a reading that is no pose, or outside the workspace, is a fault.
//! 2. [`limits::PoseGate`]: a reading that is missing or jumps is bridged; too many are a fault.
//! 3. `limits::freeze::Freeze`: an axis that stops dead from speed is a fault.
//! 4. [`toggle::Toggle`]: a count that flips is shown as its mean.
//! 5. [`crate::stages::presence`]: no force on a tip that did not come in through the surface.
//! 6. [`crate::stages::probe`]: the shown tip is no deeper and no faster than the patch answers.
//! 7. [`ceiling::Ceiling`]: a contact that is stiffer than the device renders is softened.
//! 8. [`apart::Apart`]: a force outside, or on another tip than the sensed one, is a fault.
//! 9. [`force_limits::Plausible`]: an absurd force of the model is a fault.
//! 10. [`runaway::Runaway`]: a probe that gains speed against the force is a fault.
//! 11. [`force_limits::Longest`]: the model's force is no longer than the limit.
//! 12. [`damping::Damping`]: a contact is damped in proportion to its stiffness.
//! 13. [`gains::Gains`]: a force begins with a ramp; one that stays at its limit is relieved.
//! 14. [`stillness::Stillness`]: a strong force fades without a count.
//! 15. [`force_limits::Slew`]: a force grows no faster than the slew limit, and hardly at rest.
//! 16. [`deadline::Deadline`] and [`mode::Mode`]: a late tick halves the force, `SafeRamp` ends it.
//! 17. [`account::EnergyAccount`]: a force is paid for before it is sent.
//!
//! Velocity is estimated in three places, because three errors must be avoided. [`damping`] must
//! not be late at a turn, so its estimate follows a turn within a count. [`runaway`] must not take
//! a held reading and the double displacement after it for speed gained, so it passes the raw
//! displacement through a low-pass. [`account`] needs an estimate whose error is bounded, so it
//! takes the mean over a window. For the same reason there are two backlashes: a fifth of a count
//! before the damping, where a whole count lets a contact of 400 N/m oscillate (DECISIONS.md), and
//! a whole count in the account, where less would charge a resting hand for a count that flips.

pub mod account;
pub mod apart;
pub mod ceiling;
pub mod commission;
pub mod cycle;
pub mod damping;
pub mod deadline;
pub mod device;
pub mod force_limits;
pub mod gains;
pub mod limits;
pub mod mode;
pub mod press;
pub mod runaway;
pub mod seen;
pub mod stillness;
pub mod toggle;

use nalgebra::Vector3;

use crate::fault::BuildError;
use crate::lanes::sqrt;

/// Largest acceleration of a hand that holds a handle [m/s^2]. A stop that is sharper belongs to no
/// hand, and beyond it the account promises nothing.
/// Source: derived; a stylus of 45 g takes nine newtons for it, more than the 7.9 N of the
/// strongest stylus with a profile. Hands that brake with up to 190 m/s^2 must not count as a stuck
/// encoder (`a_hand_that_brakes_evenly_is_no_stuck_encoder_wherever_its_counts_fall`).
pub(crate) const HAND_M_PER_S2: f32 = 200.0;
/// Time after which tissue no longer rings [s].
/// Source: measured; of 11 809 random stops (2 to 110 kPa, from up to 0.4 m/s) 112 still rang for
/// six reversals after 20 ms, two after 0.1 s, none after 0.15 s (DECISIONS.md); and a third more.
pub(crate) const RINGS_S: f32 = 0.2;

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
