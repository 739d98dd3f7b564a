//! Compares the stiffness of glued discs with that of the finite elements.

use serde::{Deserialize, Serialize};

use super::Judging;
use crate::pressed_patch::{PressedPatch, error_pct, rms, worst};
use crate::statics::{Unbalanced, Vector};

/// Errors of glued discs outside the fit, pressed and sheared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GluedVerdict {
    /// Root mean square error over discs and directions [%].
    pub rms_pct: f64,
    /// Largest error over discs and directions, with its sign [%].
    pub worst_pct: f64,
    /// Number of discs times directions.
    pub count: usize,
}

impl Judging<'_> {
    /// Errors of the glued discs; `None` if there are no discs.
    pub(super) fn glued(&self, pressed: &PressedPatch) -> Result<Option<GluedVerdict>, Unbalanced> {
        let error = |disc: &palpate_tissue::answer::GluedAnswer| {
            let place_m = pressed.site_m + Vector::from(disc.place_m);
            let found = pressed.solver.glued(&pressed.statics, place_m, disc.radius_m, disc.direction.into())?;
            Ok(error_pct(found.stiffness_m, disc.stiffness_over_e_m))
        };
        let errors: Vec<f64> = self.unseen.glued.iter().map(error).collect::<Result<_, Unbalanced>>()?;
        let verdict = GluedVerdict { rms_pct: rms(&errors), worst_pct: worst(&errors), count: errors.len() };
        Ok((!errors.is_empty()).then_some(verdict))
    }
}
