//! Forces of the scenes for which a finite-element answer is shipped.

use crate::answer::Answer;
use crate::scene::Scene;

/// Depths [m] and forces [N] of the shipped answer, shallow first, if it is for this scene: the
/// standard block and probe with any modulus, pressed at the centre. Empty for any other scene, and
/// if the tissue relaxes or stiffens or the probe has friction, since the answer is neo-Hookean and
/// frictionless.
#[must_use]
pub fn of(scene: &Scene) -> Vec<(f64, f64)> {
    let answer = Answer::block();
    let elastic = scene.tissue.relaxation.is_empty() && scene.tissue.most_stiffening_b() == 0.0 && scene.probe.friction == 0.0;
    if !elastic || !answer.is_for(scene) || scene.probe.position_m.unwrap_or_default() != [0.0, 0.0] {
        return Vec::new();
    }
    let centred = answer.holds.iter().filter(|h| h.place_m == [0.0; 3]);
    centred.map(|h| (h.depth_m, h.force_over_e_m2 * scene.tissue.youngs_modulus_pa)).collect()
}
