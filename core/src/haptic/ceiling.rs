//! Gain of a contact that is stiffer than the device renders.
//!
//! Above its stiffness ceiling a device vibrates: encoder, delay and amplifier turn the tissue into
//! a limit cycle. A board refuses a patch whose contact is stiffer ([`super::press`]); a desktop
//! multiplies the force by a gain. The gain follows from the stiffness at the depth limit and is
//! constant over a contact: a gain that followed the instantaneous tangent would make the force
//! depend on the path and create energy.
//!
//! * in: stiffness of the contact and ceiling [N/m], answer of the renderer
//! * out: the answer times a gain (0 .. 1)
//! * cost: one comparison
//! * failures: none; the flag `GAIN` is set

use crate::fault::ClampFlags;
use crate::stages::output::Output;

/// Gain that keeps the contact at or below the device's stiffness ceiling.
#[derive(Clone, Copy, Debug)]
pub struct Ceiling {
    most_n_per_m: f32,
    gain: f32,
}

impl Ceiling {
    /// Creates the gain for a device with this ceiling [N/m].
    #[must_use]
    pub fn new(most_n_per_m: f32) -> Self {
        Self { most_n_per_m, gain: 1.0 }
    }

    /// Follows the stiffness of the contact at the depth limit [N/m]; during a contact the gain
    /// stays as it is.
    pub fn follow(&mut self, stiffness_n_per_m: f32, touched: bool) {
        if !touched {
            self.gain = gain(stiffness_n_per_m, self.most_n_per_m);
        }
    }

    /// Multiplies the answer of the renderer by the gain.
    pub fn soften(&self, output: &mut Output) {
        if self.gain < 1.0 {
            output.force_n *= self.gain;
            output.grip_n *= self.gain;
            output.continuation_n *= self.gain;
            output.limiters.set(ClampFlags::GAIN);
        }
    }
}

/// Gain with which a contact of this stiffness is as stiff as the ceiling at most (1).
#[must_use]
pub fn gain(stiffness_n_per_m: f32, most_n_per_m: f32) -> f32 {
    if stiffness_n_per_m > most_n_per_m { most_n_per_m / stiffness_n_per_m } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn a_contact_is_as_stiff_as_the_ceiling_at_most_and_its_gain_waits_for_its_end() {
        let mut ceiling = Ceiling::new(400.0);
        let gain = |ceiling: &Ceiling| {
            let mut output = Output { force_n: Vector3::z(), grip_n: 1.0, ..Output::NONE };
            ceiling.soften(&mut output);
            assert_eq!(output.limiters.contains(ClampFlags::GAIN), output.force_n.z < 1.0);
            assert_eq!(output.grip_n, output.force_n.z, "friction gives way with the push");
            output.force_n.z
        };
        for (n_per_m, share) in [(0.0, 1.0), (400.0, 1.0), (500.0, 0.8), (4_000.0, 0.1), (f32::NAN, 1.0)] {
            ceiling.follow(n_per_m, false);
            assert_eq!(gain(&ceiling), share, "{n_per_m} N/m");
        }
        ceiling.follow(800.0, false);
        for n_per_m in [8_000.0, 40.0] {
            ceiling.follow(n_per_m, true);
            assert_eq!(gain(&ceiling), 0.5, "{n_per_m} N/m under the hand");
        }
    }
}
