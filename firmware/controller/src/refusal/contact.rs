//! Reasons why a contact is refused, as they are sent to the host, with what would be accepted.

use core::fmt;

use serde::{Deserialize, Serialize};

/// A contact that is stiffer than the device's ceiling, and the remedies, zero where there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct TooStiff {
    /// Stiffness of the contact at the depth limit [N/m].
    pub n_per_m: u32,
    /// Ceiling of the device [N/m].
    pub ceiling_n_per_m: u32,
    /// Largest Young's modulus that is accepted [Pa].
    pub softer_pa: u32,
    /// Depth limit that is accepted at the present modulus [um].
    pub shallower_um: u32,
}

/// A tip that is narrower than the elements under it, and the remedies, zero where there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub struct TooNarrow {
    /// Radius of the contact at the depth limit [um].
    pub contact_um: u32,
    /// Smallest radius of a contact on these elements [um].
    pub least_um: u32,
    /// Radius of a tip that is accepted [um].
    pub wider_um: u32,
    /// Largest Young's modulus that is accepted with that tip [Pa]; zero if the present one is.
    pub softer_pa: u32,
}

impl fmt::Display for TooStiff {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { n_per_m, ceiling_n_per_m, softer_pa, shallower_um } = *self;
        write!(
            f,
            "the contact is {n_per_m} N/m stiff at the depth limit, and the device renders {ceiling_n_per_m} N/m (stiffness_ceiling_n_per_m): take "
        )?;
        match softer_pa {
            0 => f.write_str("softer tissue")?,
            _ => write!(f, "at most {} kPa", Thousandths(softer_pa))?,
        }
        if shallower_um > 0 {
            write!(f, ", or a depth limit of at most {} mm", Thousandths(shallower_um))?;
        }
        Ok(())
    }
}

impl fmt::Display for TooNarrow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { contact_um, least_um, wider_um, softer_pa } = *self;
        write!(
            f,
            "the tip touches a radius of {} mm at the depth limit, and the elements under it need {} mm: take ",
            Thousandths(contact_um),
            Thousandths(least_um)
        )?;
        if wider_um > 0 {
            write!(f, "a tip with a radius of at least {} mm", Thousandths(wider_um))?;
            if softer_pa > 0 {
                write!(f, " on at most {} kPa", Thousandths(softer_pa))?;
            }
            f.write_str(", or ")?;
        }
        f.write_str("smaller elements (more nodes, which a faster board has time for)")
    }
}

/// Thousandths as a decimal number: micrometres in mm, or Pa in kPa.
struct Thousandths(u32);

impl fmt::Display for Thousandths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:02}", self.0 / 1000, self.0 % 1000 / 10)
    }
}
