//! Relaxation of a scene's tissue, given with its instantaneous or its long-term modulus.

use palpate::{MOST_TERMS, PronyTerm};
use serde::Deserialize;

use super::check::MODULUS_PA;
use super::{Scene, SceneError, TissueScene};

/// One term of the relaxation: a share of every force fades with a time constant. Up to three terms
/// may be given.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct RelaxationScene {
    /// Share of the instantaneous force that fades (1); all shares together are at most 0.99.
    ///
    /// * range: above 0 to 0.99
    /// * source: 0.69 and 0.16 in `beef`, fitted by `accept` T1
    pub share: f64,
    /// Time constant of the fading [s].
    ///
    /// * range: 0.001 to 200
    /// * source: 0.41 and 4.5 in `beef`, fitted by `accept` T1
    pub time_s: f64,
}

/// Placeholder for a modulus that the scene does not give.
const NOT_GIVEN: f64 = f64::NEG_INFINITY;

pub(super) fn not_given() -> f64 {
    NOT_GIVEN
}

impl TissueScene {
    /// The first three terms as parameters of the core; `check_relaxation` refuses more.
    #[must_use]
    pub fn relaxation(&self) -> [PronyTerm; MOST_TERMS] {
        let mut terms = [PronyTerm::NONE; MOST_TERMS];
        for (to, from) in terms.iter_mut().zip(&self.relaxation) {
            *to = PronyTerm { share: from.share as f32, time_s: from.time_s as f32 };
        }
        terms
    }

    /// Share of a force that remains after an infinitely long hold (1).
    #[must_use]
    pub fn lasting_share(&self) -> f64 {
        1.0 - self.relaxation.iter().map(|term| term.share).sum::<f64>()
    }
}

impl Scene {
    /// Computes the instantaneous Young's modulus if the scene gives the long-term one. A scene
    /// gives exactly one of the two.
    pub(super) fn take_modulus(&mut self, file: &str, text: &str) -> Result<(), SceneError> {
        let lasting = self.tissue.lasting_share();
        let given = self.tissue.youngs_modulus_pa != NOT_GIVEN;
        match self.tissue.long_term_modulus_pa {
            None if !given => {
                let line = text.lines().position(|line| line.trim() == "[tissue]").map_or(1, |n| n + 1);
                let what = "key \"youngs_modulus_pa\" is missing in [tissue]: add it, or long_term_modulus_pa, as in the presets under host-sim/scenes";
                Err(SceneError::Toml { file: file.into(), line, what: what.into(), surplus: None })
            }
            None => Ok(()),
            Some(_) if given => self.bad(
                "tissue",
                "has both youngs_modulus_pa, the modulus at once, and long_term_modulus_pa, the one that stays: keep one",
            ),
            Some(long_pa) if !MODULUS_PA.contains(&long_pa) => {
                let why = format!("= {long_pa} is out of range: give {} .. {}", MODULUS_PA.start(), MODULUS_PA.end());
                self.bad("tissue.long_term_modulus_pa", &why)
            }
            Some(long_pa) => {
                // checked first, so that shares that leave no elastic force are named as the cause
                self.check_relaxation()?;
                self.tissue.youngs_modulus_pa = long_pa / lasting;
                // the moduli of regions are long-term ones, too
                for region in &mut self.tissue.region {
                    region.youngs_modulus_pa /= lasting;
                }
                Ok(())
            }
        }
    }

    /// Checks the number of terms and their shares. The core checks the times, whose range depends
    /// on the tick.
    pub(super) fn check_relaxation(&self) -> Result<(), SceneError> {
        let terms = &self.tissue.relaxation;
        if terms.len() > MOST_TERMS {
            let why = format!("has {} terms, {MOST_TERMS} fit: leave out those with the smallest shares", terms.len());
            return self.bad("tissue.relaxation", &why);
        }
        for (n, term) in terms.iter().enumerate() {
            if term.share.is_nan() || term.share <= 0.0 {
                let why = format!("= {} must be above zero: remove the term, or give its share of the force", term.share);
                return self.bad(&format!("tissue.relaxation[{n}].share"), &why);
            }
        }
        let lasting = self.tissue.lasting_share();
        if lasting < LEAST_LASTING {
            let why = format!(
                "has shares that sum to {:.3}, at most {} may fade: make them smaller, some of the force must stay",
                1.0 - lasting,
                1.0 - LEAST_LASTING
            );
            return self.bad("tissue.relaxation", &why);
        }
        Ok(())
    }
}

/// Smallest share of a force that must remain (1): the bound of the core.
const LEAST_LASTING: f64 = 0.01;
