//! Detects, at the first touch, a force that accelerates the probe instead of holding it back: the
//! sign of a motor or an encoder is wrong.
//!
//! With a wrong sign the tissue pulls, and gives the hand the energy that it should take: the
//! square of the inward speed grows in proportion to the work of the force, by two over the mass
//! that moves. A hand that presses tissue never shows this, because its own push weakens as it
//! approaches its target. So at every doubling of the work that the force should have taken, from
//! 0.1 mJ on, the square of the speed is compared with that at the doubling before. The force is
//! off until the probe has left if the square grows four times in a row by at least a tenth, each
//! time by as much as that work gives to a mass between 25 g and 2 kg, and if the mass stays the
//! same within a factor of two. The third such contact in a row is [`Fault::WrongSign`].
//!
//! A contact that takes 1.6 mJ and does not end in such a row proves the sign and ends the check
//! until the next arming. A hand that speeds up on purpose at its first touch may lose the force of
//! that touch; none was seen to do so three times in a row.
//!
//! Three cases are not detected. A hand that is stiffer than the tissue holds against a wrong sign
//! without speeding up; its force is then bounded by the force limit alone. An axis along the
//! surface has no force at the first touch that could reveal its sign. If encoders and motors are
//! mirrored alike, the contact takes and gives energy as it should.
//!
//! * in: low-passed speed into the tissue [m/s], energy given to the hand since the touch [J]
//! * out: gain (0 or 1) on the force
//! * cost: 40 instructions of a Cortex-M4F in the first contact, 3 after it, estimated
//! * failures: [`Fault::WrongSign`]

use crate::fault::Fault;

/// Work at which the speed is first recorded [J].
const FIRST_J: f32 = 0.1e-3;
/// Number of doublings of the work in a row in which the speed has to grow.
const DOUBLINGS: u8 = 4;
/// Least growth of the square of the speed in each doubling (1).
const GROWTH: f32 = 1.1;
/// Least and largest growth of the square of the speed per work [1/kg]: two over 2 kg and two over
/// 25 g.
const PER_WORK: [f32; 2] = [1.0, 80.0];
/// Least growth per work, as a share of that in the doubling before (1): a mass stays the same,
/// whereas a hand that speeds up by itself does so whatever the work is.
const SAME_MASS: f32 = 0.5;
/// A contact that took this much energy without such a row has the right sign [J].
const PROOF_J: f32 = FIRST_J * 16.0;
/// Number of such contacts in a row that is a fault.
const CONTACTS: u8 = 3;

/// Watches the first contacts after arming.
#[derive(Clone, Copy, Debug, Default)]
pub struct SignWatch {
    /// True if a contact proved the right sign.
    proven: bool,
    /// Contacts in a row in which the force accelerated the probe.
    driven: u8,
    /// Work that the force should have taken when the speed was last recorded, and the signed
    /// square of that speed [J, m^2/s^2].
    taken_j: f32,
    square: f32,
    /// Growth of the square of the speed per work in the last doubling in which the speed grew
    /// [1/kg].
    per_work: f32,
    /// Doublings in a row in which the speed grew.
    doublings: u8,
    /// True if the force is off until the probe has left.
    off: bool,
}

impl SignWatch {
    /// Runs one cycle; `inward_m_per_s` is the low-passed speed against the contact's normal, and
    /// `given_j` is the energy given to the hand since the touch, negative while the tissue stores
    /// energy.
    ///
    /// # Errors
    /// Fails with [`Fault::WrongSign`] if enough contacts show that the force drives the probe into
    /// the tissue.
    pub fn judge(&mut self, inward_m_per_s: f32, given_j: f32, touched: bool) -> Result<(), Fault> {
        if self.proven {
            return Ok(());
        }
        if !touched {
            // an unfinished row of doublings is evidence against the sign, however much energy was
            // taken
            let proven = self.taken_j >= PROOF_J && !self.off && self.doublings == 0;
            *self = Self { proven, driven: self.driven, ..Self::default() };
            return Ok(());
        }
        let taken_j = -given_j;
        if !(taken_j >= FIRST_J && taken_j >= 2.0 * self.taken_j) {
            return Ok(());
        }
        let square = inward_m_per_s * inward_m_per_s.abs();
        let (gained, work_j) = (square - self.square, taken_j - self.taken_j);
        let driven = gained >= (GROWTH - 1.0) * self.square.abs()
            && gained >= PER_WORK[0] * work_j
            && gained <= PER_WORK[1] * work_j
            && gained >= SAME_MASS * self.per_work * work_j
            && self.taken_j > 0.0;
        (self.taken_j, self.square) = (taken_j, square);
        (self.doublings, self.per_work) = if driven { (self.doublings + 1, gained / work_j) } else { (0, 0.0) };
        if self.doublings == DOUBLINGS {
            self.off = true;
            self.driven += 1;
        }
        match self.driven >= CONTACTS {
            true => Err(Fault::WrongSign),
            false => Ok(()),
        }
    }

    /// Whether a contact has proved the right sign: nothing is left to check then.
    #[must_use]
    #[inline(always)]
    pub fn proven(&self) -> bool {
        self.proven
    }

    /// Gain on the force (1).
    #[must_use]
    pub fn gain(&self) -> f32 {
        if self.off { 0.0 } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feeds the watch with work that doubles from step to step, while the square of the speed
    /// grows by `per_work` per work after the first step, from `from_m_per_s` on. Returns the
    /// answer, and whether the force is off.
    fn contact(watch: &mut SignWatch, from_m_per_s: f32, per_work: &[f32]) -> (Result<(), Fault>, bool) {
        let (mut taken_j, mut square) = (FIRST_J, from_m_per_s * from_m_per_s);
        let mut answer = watch.judge(from_m_per_s, -taken_j, true);
        for growth in per_work {
            square += growth * taken_j;
            taken_j *= 2.0;
            answer = answer.and(watch.judge(square.max(0.0).sqrt(), -taken_j * 1.0001, true));
        }
        (answer, watch.gain() == 0.0)
    }

    fn leave(watch: &mut SignWatch) {
        assert_eq!(watch.judge(0.0, 0.0, false), Ok(()));
        assert_eq!(watch.gain(), 1.0, "the next contact has its force");
    }

    #[test]
    fn a_force_that_gives_its_work_as_speed_is_off_at_once_and_a_fault_in_the_third_contact() {
        // from 33 g to 1 kg, from rest and from up to 0.05 m/s
        for (mass_kg, from_m_per_s) in [(0.033, 0.0), (0.05, 0.05), (0.3, 0.03), (1.0, 0.0), (1.0, 0.04)] {
            let mut watch = SignWatch::default();
            let growth = [2.0 / mass_kg; 4];
            assert_eq!(contact(&mut watch, from_m_per_s, &growth[..3]), (Ok(()), false), "{mass_kg} kg: three doublings");
            leave(&mut watch);
            for _ in 0..2 {
                assert_eq!(contact(&mut watch, from_m_per_s, &growth), (Ok(()), true), "{mass_kg} kg");
                leave(&mut watch);
            }
            assert_eq!(contact(&mut watch, from_m_per_s, &growth).0, Err(Fault::WrongSign), "{mass_kg} kg");
        }
    }

    #[test]
    fn a_hand_that_yields_goes_on_evenly_or_speeds_up_by_itself_is_none() {
        for growth in
            [[-20.0; 4], [0.0; 4], [0.5; 4], [200.0; 4], [30.0, 30.0, 30.0, -1.0], [30.0, 0.0, 30.0, 30.0], [17.9, 7.1, 6.5, 1.7]]
        {
            let mut watch = SignWatch::default();
            for _ in 0..3 {
                assert_eq!(contact(&mut watch, 0.2, &growth), (Ok(()), false), "{growth:?}");
                watch.judge(0.0, 0.0, false).unwrap();
                watch.proven = false;
            }
        }
        // the same mass would have gained as much per work in every doubling
        let one_mass = [30.0, 30.0, 20.0, 20.0];
        assert_eq!(contact(&mut SignWatch::default(), 0.02, &one_mass), (Ok(()), true));
        let two_masses = [30.0, 30.0, 10.0, 10.0];
        assert_eq!(contact(&mut SignWatch::default(), 0.02, &two_masses), (Ok(()), false));
        // fast enough that what the work could give is less than a tenth
        assert_eq!(contact(&mut SignWatch::default(), 1.0, &[20.0; 4]), (Ok(()), false));
    }

    #[test]
    fn one_contact_that_took_enough_ends_the_watch_and_a_light_one_does_not() {
        let driven = [30.0; 4];
        let mut watch = SignWatch::default();
        assert_eq!(contact(&mut watch, 0.2, &[-10.0; 3]), (Ok(()), false));
        leave(&mut watch);
        assert_eq!(contact(&mut watch, 0.05, &driven), (Ok(()), true), "0.8 mJ prove nothing");
        leave(&mut watch);
        assert_eq!(contact(&mut watch, 0.05, &[-10.0, 30.0, 30.0, 30.0]), (Ok(()), false));
        leave(&mut watch);
        assert_eq!(contact(&mut watch, 0.05, &driven), (Ok(()), true), "nor do 1.6 mJ that end driven");
        leave(&mut watch);
        assert_eq!(contact(&mut watch, 0.2, &[-10.0; 4]), (Ok(()), false));
        leave(&mut watch);
        assert_eq!(contact(&mut watch, 0.05, &driven), (Ok(()), false), "1.6 mJ do");
    }

    #[test]
    fn an_energy_that_is_no_number_changes_nothing() {
        let mut watch = SignWatch::default();
        for given_j in [f32::NAN, f32::INFINITY, 0.0, 1.0] {
            assert_eq!(watch.judge(0.1, given_j, true), Ok(()));
            assert_eq!((watch.gain(), watch.taken_j), (1.0, 0.0), "{given_j}");
        }
    }
}
