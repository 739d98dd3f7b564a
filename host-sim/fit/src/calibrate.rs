//! Calibration fits the constants of a patch to a finite-element reference.
//!
//! The unknowns are a positive multiplier for every spring, for every node's volume stiffness and
//! for every foundation point under the probe, and seven scalars. The targets are the force on the
//! probe at places over a disc and at several depths, the shape of the dent at the centre and, if
//! the reference has them, discs that are glued to the surface, pressed and sheared
//! ([`crate::statics::Glued`]). Every simulation is the *nonlinear* static solution of the model
//! that the tick runs ([`crate::statics`]), with its adjoint: one factored tangent gives a force
//! and its derivatives with respect to thousands of unknowns. [`gauss_newton`] does the fitting.

pub mod gauss_newton;
mod measurement;
pub mod places;
mod sweep;
pub mod targets;
mod unknowns;

pub use measurement::Measurement;
pub use sweep::{Objective, Positions, Sweep, too_many_lost};
pub use targets::{DentTarget, ForceTarget, GluedTarget, Targets};
pub use unknowns::Unknowns;

use palpate::Params;
use thiserror::Error;

use crate::statics::{Statics, Unbalanced};
use palpate_tissue::patch::{Material, Multipliers, Patch, RimSprings};
use palpate_tissue::tissue::Tissue;

/// Reason why a calibration ended without a result.
#[derive(Debug, Error)]
pub enum CalibrateError {
    /// The patch cannot be built.
    #[error("the patch cannot be built: {0}")]
    Build(#[from] palpate::BuildError),
    /// The uncalibrated patch has no equilibrium under a press.
    #[error("the uncalibrated patch cannot be pressed: {0}")]
    Press(#[from] Unbalanced),
}

/// Extent of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Number of places over the disc, without the centre.
    pub places: usize,
    /// Maximum number of rounds.
    pub rounds: usize,
    /// Smallest gain of a round as a share of the objective (1); the fit ends with a round that
    /// gains less.
    pub least_gain: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { places: 80, rounds: 14, least_gain: 0.002 }
    }
}

/// Record of one round of a fit.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Round {
    /// Number of evaluations of the objective so far; each solves all presses.
    pub evaluations: usize,
    /// Value of the objective (1): squared errors in units of their tolerance, plus squared
    /// unknowns in units of their prior widths.
    pub cost: f64,
    /// Root mean square of the force errors over all places and depths [%].
    pub force_rms_pct: f64,
    /// Mean distance between the surface nodes and the reference, over all dents [mm].
    pub dent_mean_mm: f64,
    /// Time since the start [s].
    pub elapsed_s: f64,
}

/// A calibrated patch.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// Parameters with the fitted scalars.
    pub params: Params,
    /// Patch built with the fitted multipliers and these parameters.
    pub patch: Patch,
    /// Records of all rounds, first to last.
    pub rounds: Vec<Round>,
    /// Number of presses away from the centre that have no equilibrium on the fitted patch and were
    /// not counted in the last round.
    pub lost_presses: usize,
}

/// Fits the patch of a tissue to `targets`, with its far field attached if it has one. Rim springs
/// are never unknowns, so that the rim springs of another organ can replace them.
///
/// # Errors
/// See [`CalibrateError`].
pub fn calibrate(
    tissue: &Tissue,
    material: &Material,
    rim: Option<&RimSprings>,
    params: &Params,
    targets: &Targets,
    settings: &Settings,
    progress: &mut dyn FnMut(&Round),
) -> Result<Calibration, CalibrateError> {
    let patch = built(tissue, material, rim, None);
    let statics = Statics::of(&patch.model(), params)?;
    let unknowns = Unknowns::of(&statics, tissue, targets.reach_m());
    let mut objective = Objective::new(statics, unknowns, targets)?;
    let rounds = gauss_newton::fit(&mut objective, settings, progress)?;
    let (multipliers, params) = objective.unknowns().result(objective.statics(), objective.place(), params);
    let mut patch = built(tissue, material, rim, Some(&multipliers));
    patch.set_fitted_places(settings.places as u32);
    Ok(Calibration { params, patch, rounds, lost_presses: objective.lost_presses() })
}

fn built(tissue: &Tissue, material: &Material, rim: Option<&RimSprings>, multipliers: Option<&Multipliers>) -> Patch {
    let mut patch = Patch::build(tissue, material, multipliers);
    rim.into_iter().for_each(|rim| patch.set_rim(rim));
    patch
}
