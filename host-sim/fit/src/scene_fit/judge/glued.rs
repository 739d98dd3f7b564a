//! Compares the stiffness of glued discs with that of the finite elements. No probe is glued, so
//! these discs alone are solved statically.

use serde::{Deserialize, Serialize};

use super::Judging;
use crate::pressed_patch::{PressedPatch, error_pct, rms, worst};
use crate::statics::{Unbalanced, Vector};
use palpate_tissue::error::Error;
use palpate_tissue::session::Session;

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
    pub(super) fn glued(&self, session: &Session) -> Result<Option<GluedVerdict>, Error> {
        if self.unseen.glued.is_empty() {
            return Ok(None);
        }
        let unbalanced = |cause: Unbalanced| Error::Check(format!("the patch has no equilibrium under a glued disc: {cause}"));
        let pressed = PressedPatch::of(&session.patch, &session.params).map_err(unbalanced)?;
        let error = |disc: &palpate_tissue::answer::GluedAnswer| {
            let place_m = pressed.site_m + Vector::from(disc.place_m);
            let found = pressed.solver.glued(&pressed.statics, place_m, disc.radius_m, disc.direction.into())?;
            Ok(error_pct(found.stiffness_m, disc.stiffness_over_e_m))
        };
        let errors: Vec<f64> = self.unseen.glued.iter().map(error).collect::<Result<_, Unbalanced>>().map_err(unbalanced)?;
        Ok(Some(GluedVerdict { rms_pct: rms(&errors), worst_pct: worst(&errors), count: errors.len() }))
    }
}
