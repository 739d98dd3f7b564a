//! Prepares the reference for a scene's model: the answer for the whole organ, the depths of the
//! evaluation, and the tightest tolerance that these can resolve.

use super::judge::Judge;
use crate::far_field::fitted::{Prepared, Recipe, Truth};
use palpate_tissue::error::Error;
use palpate_tissue::scene::Scene;

/// Accuracy of the forces of the reference itself [%].
const KNOWN_PCT: f64 = 0.3;
/// Radius and edge length of the patches on whose mesh the whole organ is solved [probe radii]: the
/// first, or the second if the organ is too small for the first.
const SOLVED: [[f64; 2]; 2] = [[2.0, 0.56], [1.5, 0.56]];

/// Answer for the whole organ, with the depths of the evaluation.
pub struct Known {
    /// Answer for the whole organ.
    pub truth: Truth,
    /// Depths at which models are evaluated.
    pub judge: Judge,
}

impl Known {
    /// Uses the stored answer, or solves the scene by finite elements, which takes minutes for an
    /// organ. Calls `progress` with messages.
    ///
    /// # Errors
    /// Fails if the tolerance [%] is invalid or too tight for the answer, if the scene allows no
    /// far field, or if the answer lacks holds.
    pub fn of(scene: &Scene, tolerance_pct: f64, progress: impl Fn(&str) + Sync) -> Result<Self, Error> {
        if !(tolerance_pct > 0.0 && tolerance_pct <= 100.0) {
            return Err(Error::Usage(format!("--tolerance-pct {tolerance_pct}: give a percentage above 0, at most 100")));
        }
        refuse_unknowable(tolerance_pct, KNOWN_PCT)?;
        let probe_m = scene.probe.radius_m;
        progress("meshing the whole");
        let [most, least] = SOLVED.map(|[radius, element]| Recipe::new(radius * probe_m, element * probe_m, probe_m));
        // if both patches are refused, the error is that of the smaller one
        let placed = Prepared::of(scene, &most).or_else(|_| Prepared::of(scene, &least))?.placed;
        let truth = Truth::of(scene, &placed, |done, all| {
            progress(&format!("finite elements of the whole: {done} of {all} presses"));
        })?;
        if let Truth::Organ(map) = &truth {
            refuse_unknowable(tolerance_pct, KNOWN_PCT.max(100.0 * map.misfit))?;
        }
        let judge = truth.ask(|reference| Judge::of(scene, placed.tissue.depth_limit_m, reference))?;
        Ok(Self { truth, judge })
    }
}

fn refuse_unknowable(asked_pct: f64, known_pct: f64) -> Result<(), Error> {
    if asked_pct >= known_pct {
        return Ok(());
    }
    let nearest = (known_pct * 10.0).ceil() / 10.0;
    Err(Error::Usage(format!(
        "--tolerance-pct {asked_pct}: the reference itself knows the forces of this scene to {known_pct:.2} % only: take {nearest:.1} or more"
    )))
}
