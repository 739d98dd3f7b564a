//! Presses the whole of a scene for the search, and refuses a tolerance that they cannot resolve.

use crate::far_field::prepared::{Prepared, Recipe};
use crate::scene_fit::{Level, PiecePresses};
use crate::solved::Solved;
use palpate_tissue::error::Error;
use palpate_tissue::scene::Scene;

/// Accuracy of the forces of the reference itself [%].
const KNOWN_PCT: f64 = 0.3;
/// Radius and edge length of the patches on whose mesh the whole organ is solved [probe radii]: the
/// first, or the second if the organ is too small for the first.
const SOLVED: [[f64; 2]; 2] = [[2.0, 0.56], [1.5, 0.56]];

/// Returns the whole of a scene, and its presses for the fits and the evaluation of all candidates.
/// Those of an organ take minutes, unless they are in `solved`. Calls `progress` with messages.
///
/// # Errors
/// Fails if the tolerance [%] is too tight for the reference, or if the scene allows no far field.
pub fn presses(
    scene: &Scene,
    tolerance_pct: f64,
    level: Level,
    solved: &Solved,
    progress: impl Fn(&str) + Sync,
) -> Result<(Prepared, PiecePresses), Error> {
    refuse_unknowable(tolerance_pct, KNOWN_PCT)?;
    progress("meshing the whole");
    let probe_m = scene.probe.radius_m;
    let [most, least] = SOLVED.map(|[radius, element]| Recipe::new(radius * probe_m, element * probe_m, probe_m));
    // if both patches are refused, the error is that of the smaller one
    let prepared = Prepared::of(scene, &most).or_else(|_| Prepared::of(scene, &least))?;
    let presses = PiecePresses::of(scene, &prepared.placed, (level, true), solved, |done, all| {
        progress(&format!("finite elements of the whole: {done} of {all} presses"));
    })?;
    refuse_unknowable(tolerance_pct, KNOWN_PCT.max(100.0 * presses.known.misfit()))?;
    Ok((prepared, presses))
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
