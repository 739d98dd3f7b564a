//! Calibration: the constants of a patch are fitted to a finite-element reference.
//!
//! The unknowns are a positive multiplier on every spring, every node's volume stiffness and every
//! foundation point under the probe, and five scalars. The targets are the force on the probe at
//! places over a disc at several depths, the shape of the dent at the centre and, if the reference
//! has them, discs glued to the surface, pressed and sheared ([`crate::statics::Glued`]). Every
//! simulation is the *nonlinear* static solution of the model that the tick runs
//! ([`crate::statics`]), with its adjoint: one factored tangent gives a force and its derivatives
//! with respect to thousands of unknowns. [`gauss_newton`] does the fitting; [`annealing`]
//! (paper 004) minimises the same objective, for comparison.

pub mod accuracy;
pub mod annealing;
pub mod gauss_newton;
mod measurement;
pub mod places;
pub mod reference_map;
pub mod schedule;
mod sweep;
pub mod targets;
mod unknowns;

pub use measurement::Measurement;
pub use sweep::{Objective, Positions, Sweep};
pub use targets::{DentTarget, ForceTarget, GluedTarget, Targets};
pub use unknowns::Unknowns;

use palpate::Params;
use thiserror::Error;

use crate::statics::{Statics, Unbalanced};
use palpate_tissue::patch::{Material, Multipliers, Patch, RimSprings};
use palpate_tissue::tissue::Tissue;

/// Why a calibration ended without a result.
#[derive(Debug, Error)]
pub enum CalibrateError {
    /// The patch as built.
    #[error("the patch cannot be built: {0}")]
    Build(#[from] palpate::BuildError),
    /// The first press.
    #[error("the uncalibrated patch cannot be pressed: {0}")]
    Press(#[from] Unbalanced),
    /// The reference.
    #[error("the reference has no press at the centre deep enough: run `palpate reference` with these depths")]
    Targets,
}

/// Extent of the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Places over the disc, without the centre.
    pub places: usize,
    /// Largest number of rounds, or of evaluations for annealing.
    pub rounds: usize,
    /// The fit ends with a round that gains less than this share of the objective (1).
    pub least_gain: f64,
    /// Method of the fit.
    pub fit: Fit,
}

/// Method of minimising the objective.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// [`gauss_newton`].
    GaussNewton,
    /// [`annealing`].
    Annealing,
}

impl Default for Settings {
    fn default() -> Self {
        Self { places: 80, rounds: 14, least_gain: 0.002, fit: Fit::GaussNewton }
    }
}

/// One round of a fit.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Round {
    /// Evaluations of the objective so far, each the solution of all presses.
    pub evaluations: usize,
    /// The objective: squared errors in units of their tolerance, plus squared unknowns in units of
    /// their prior widths.
    pub cost: f64,
    /// Root mean square of the force errors over all places and depths [%].
    pub force_rms_pct: f64,
    /// Mean distance of the surface nodes from the reference, over the depths of the dents [mm].
    pub dent_mean_mm: f64,
    /// Time since the start [s].
    pub elapsed_s: f64,
}

/// A calibrated patch.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// Fitted multipliers.
    pub multipliers: Multipliers,
    /// The parameters with the fitted scalars.
    pub params: Params,
    /// The patch built with these multipliers and parameters.
    pub patch: Patch,
    /// Every round.
    pub rounds: Vec<Round>,
    /// Presses off the centre that have no equilibrium on the fitted patch, and did not count in
    /// the last round.
    pub lost_presses: usize,
}

/// Fits a tissue's patch to `targets`, with its far field attached if it has one: rim springs are
/// never unknowns, so that another organ's can take their place.
///
/// # Errors
/// [`CalibrateError`].
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
    let rounds = match settings.fit {
        Fit::GaussNewton => gauss_newton::fit(&mut objective, settings, progress)?,
        Fit::Annealing => annealing::fit(&mut objective, settings.rounds, progress)?,
    };
    let (multipliers, params) = objective.unknowns().result(objective.statics(), objective.place(), params);
    let mut patch = built(tissue, material, rim, Some(&multipliers));
    patch.set_fitted_places(settings.places as u32);
    Ok(Calibration { multipliers, params, patch, rounds, lost_presses: objective.lost_presses() })
}

fn built(tissue: &Tissue, material: &Material, rim: Option<&RimSprings>, multipliers: Option<&Multipliers>) -> Patch {
    let mut patch = Patch::build(tissue, material, multipliers);
    rim.into_iter().for_each(|rim| patch.set_rim(rim));
    patch
}
