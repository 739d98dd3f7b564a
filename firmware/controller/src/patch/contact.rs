//! Refuses a patch whose contact is too stiff for the device, or whose tip is narrower than the
//! elements under it ([`palpate::haptic::press`]), with what would be accepted instead.
//!
//! Every remedy is measured on the patch itself before it is offered. Stiffness is cured by softer
//! tissue or a lower depth limit, at which the contact is smaller; a narrow tip by a wider one,
//! which is stiffer and may need softer tissue as well.

use palpate::haptic::press::{self, Press};
use palpate::{BuildError, Fault, Params, Probe};

use super::Patch;
use crate::refusal::Refusal;
use crate::refusal::contact::{TooNarrow, TooStiff};

/// Name of the stiffness in [`BuildError::OutOfRange`] if the tip finds no resistance at the depth
/// limit: it misses the surface, or slips through between its points.
pub const PUSH: &str = "stiffness under the tip at the patch's site in m";
/// Lower depths that are tried, as shares of the depth limit: eighths.
const EIGHTHS: u8 = 8;
/// Unit in which lower depths and wider radii are given [um].
const TENTH_MM_UM: f32 = 100.0;
/// Unit in which softer moduli are given [Pa].
const TEN_PA: f32 = 10.0;
/// Share of the ceiling at which a softer modulus is tried first, and share of one try that is the
/// next (1): the contact of a flat tip depends on how it was reached.
const SHARE: f32 = 0.98;
const NEXT_SHARE: f32 = 0.92;
/// Number of softer moduli that are tried.
const TRIES: u8 = 4;

/// Contact of a patch at its depth limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Tangent stiffness per pascal of Young's modulus [m].
    tangent_m: f32,
    /// Size of the elements at the site [m].
    element_m: f32,
}

impl Patch<'_> {
    /// Stiffness of the contact at the depth limit [N/m]; zero before it was measured.
    #[must_use]
    pub fn stiffness_n_per_m(&self) -> f32 {
        self.contact.map_or(0.0, |contact| contact.tangent_m * self.params.youngs_modulus_pa)
    }

    /// Checks the contact for a device with this stiffness ceiling [N/m]; measures it first, if it
    /// has not been. A measurement leaves the patch at rest. `after_round` is called after every
    /// tick of it.
    ///
    /// # Errors
    /// [`Refusal::ContactStiff`] or [`Refusal::TipNarrow`] with what is accepted instead;
    /// [`Refusal::PatchStep`] or [`Refusal::PatchSite`] if the patch diverges under the press or
    /// does not resist it.
    pub fn check_contact(&mut self, ceiling_n_per_m: f32, after_round: &mut dyn FnMut()) -> Result<(), Refusal> {
        let own = self.own_press();
        let contact = match self.contact {
            Some(contact) => contact,
            None => {
                // a law has no elements that a narrow tip could slip between
                let element_m = if self.model.law.is_some() { 0.0 } else { press::element_m(&self.model, self.site_m) };
                after_round();
                let tangent_m = self.tangent_m(own, after_round).map_err(|_| Refusal::PatchStep)?;
                *self.contact.insert(Contact { tangent_m, element_m })
            }
        };
        if self.narrow(own, contact.element_m) {
            return Err(Refusal::TipNarrow(self.wider(contact, ceiling_n_per_m, after_round)));
        }
        BuildError::within(PUSH, contact.tangent_m, f32::MIN_POSITIVE, f32::MAX)?;
        let n_per_m = self.stiffness_n_per_m();
        if n_per_m <= ceiling_n_per_m {
            return Ok(());
        }
        Err(Refusal::ContactStiff(TooStiff {
            n_per_m: n_per_m as u32,
            ceiling_n_per_m: ceiling_n_per_m as u32,
            softer_pa: self.softer_pa(own, contact.tangent_m, ceiling_n_per_m, after_round),
            shallower_um: self.shallower_um(contact, ceiling_n_per_m, after_round),
        }))
    }

    /// Checks a modulus [Pa] that is requested while the patch is in use.
    ///
    /// # Errors
    /// [`Refusal::ModulusOutOfRange`], and [`Refusal::ContactStiff`] with the largest modulus that
    /// is accepted.
    pub fn check_modulus(&self, youngs_modulus_pa: f32, ceiling_n_per_m: f32) -> Result<(), Refusal> {
        self.within_range(youngs_modulus_pa)?;
        let tangent_m = self.contact.map_or(0.0, |contact| contact.tangent_m);
        let n_per_m = tangent_m * youngs_modulus_pa;
        if n_per_m > ceiling_n_per_m {
            return Err(Refusal::ContactStiff(TooStiff {
                n_per_m: n_per_m as u32,
                ceiling_n_per_m: ceiling_n_per_m as u32,
                softer_pa: softer_pa(tangent_m, ceiling_n_per_m),
                shallower_um: 0,
            }));
        }
        Ok(())
    }

    fn own_press(&self) -> Press {
        Press { radius_m: self.params.probe.radius_m, depth_m: self.model.depth_limit_m }
    }

    fn tangent_m(&mut self, press: Press, after_round: &mut dyn FnMut()) -> Result<f32, Fault> {
        // a wider tip presses more triangles, and a measurement has more time than a tick
        let most_pressed = core::mem::replace(&mut self.tuned.most_pressed, usize::MAX);
        let measured = press::tangent_m(&self.model, &mut self.tuned, &mut self.state, self.site_m, press, after_round);
        self.tuned.most_pressed = most_pressed;
        measured
    }

    fn narrow(&self, press: Press, element_m: f32) -> bool {
        let probe = Probe { radius_m: press.radius_m, ..self.params.probe };
        // also true for NaN
        let wide = press::contact_radius_m(&probe, press.depth_m) >= press::least_width(probe.shape) * element_m;
        !wide // also where the width is no number
    }

    /// A softer modulus at which a press is accepted [Pa]; zero if none of those tried is.
    fn softer_pa(&mut self, press: Press, tangent_m: f32, ceiling_n_per_m: f32, after_round: &mut dyn FnMut()) -> u32 {
        let mut most_n_per_m = SHARE * ceiling_n_per_m;
        let mut found_pa = 0;
        for _ in 0..TRIES {
            let pascal = softer_pa(tangent_m, most_n_per_m);
            self.retuned(pascal as f32);
            let softer = self.tangent_m(press, after_round).map(|tangent_m| tangent_m * pascal as f32);
            if softer.is_ok_and(|n_per_m| n_per_m > 0.0 && n_per_m <= ceiling_n_per_m) {
                found_pa = pascal;
                break;
            }
            most_n_per_m *= NEXT_SHARE;
        }
        self.retuned(self.params.youngs_modulus_pa);
        found_pa
    }

    /// Derives the masses for another modulus [Pa], without taking it.
    fn retuned(&mut self, youngs_modulus_pa: f32) {
        Params { youngs_modulus_pa, ..self.params }.retune(&self.model, &mut self.tuned);
    }

    /// The deepest of the lower depth limits that is accepted [um]; zero if none is.
    fn shallower_um(&mut self, contact: Contact, ceiling_n_per_m: f32, after_round: &mut dyn FnMut()) -> u32 {
        let own = self.own_press();
        for eighths in (1..EIGHTHS).rev() {
            let share = f32::from(eighths) / f32::from(EIGHTHS);
            let depth_um = (share * own.depth_m * 1e6 / TENTH_MM_UM) as u32 * TENTH_MM_UM as u32;
            let press = Press { depth_m: depth_um as f32 * 1e-6, ..own };
            if depth_um == 0 || self.narrow(press, contact.element_m) {
                break;
            }
            let stiffness = self.tangent_m(press, after_round).map(|tangent_m| tangent_m * self.params.youngs_modulus_pa);
            if stiffness.is_ok_and(|n_per_m| n_per_m > 0.0 && n_per_m <= ceiling_n_per_m) {
                return depth_um;
            }
        }
        0
    }

    /// The remedies for a tip that is too narrow.
    fn wider(&mut self, contact: Contact, ceiling_n_per_m: f32, after_round: &mut dyn FnMut()) -> TooNarrow {
        let (own, probe) = (self.own_press(), self.params.probe);
        let least_m = press::least_radius_m(&probe, own.depth_m, contact.element_m);
        let mut found = TooNarrow {
            contact_um: to_um(press::contact_radius_m(&probe, own.depth_m)),
            least_um: to_um(press::least_width(probe.shape) * contact.element_m),
            wider_um: 0,
            softer_pa: 0,
        };
        // rounded up
        let wider_um = ((least_m * 1e6 / TENTH_MM_UM) as u32 + 1) * TENTH_MM_UM as u32;
        let press = Press { radius_m: wider_um as f32 * 1e-6, ..own };
        if let Ok(tangent_m) = self.tangent_m(press, after_round)
            && tangent_m > 0.0
        {
            let stiff = tangent_m * self.params.youngs_modulus_pa > ceiling_n_per_m;
            found.softer_pa = if stiff { self.softer_pa(press, tangent_m, ceiling_n_per_m, after_round) } else { 0 };
            found.wider_um = if stiff && found.softer_pa == 0 { 0 } else { wider_um };
        }
        found
    }
}

/// Modulus with which a contact of this stiffness per pascal is at the ceiling at most [Pa].
fn softer_pa(tangent_m: f32, ceiling_n_per_m: f32) -> u32 {
    (ceiling_n_per_m / tangent_m / TEN_PA) as u32 * TEN_PA as u32
}

fn to_um(length_m: f32) -> u32 {
    (length_m * 1e6) as u32
}

#[cfg(test)]
mod tests;
