//! Forces of the scenes for which a finite-element answer is stored: shipped, or beside a patch.

use crate::answer::Answer;
use crate::scene::{Drive, Scene};

/// Relative difference below which depths count as equal (1).
const SAME: f64 = 1e-6;

/// Depths [m] and forces [N], shallow first, of the answer that is stored for this scene, with any
/// modulus: that of `palpate fit` beside the scene's patch, or the shipped one of the standard
/// block pressed at the centre. Empty for any other scene, and if the tissue relaxes or stiffens or
/// the probe has friction, since the answers are neo-Hookean and frictionless.
#[must_use]
pub fn of(scene: &Scene) -> Vec<(f64, f64)> {
    let elastic = scene.tissue.relaxation.is_empty() && scene.tissue.most_stiffening_b() == 0.0 && scene.probe.friction == 0.0;
    if !elastic || scene.probe.position_m.unwrap_or_default() != [0.0, 0.0] {
        return Vec::new();
    }
    let beside = scene.solver.patch.as_deref().and_then(|patch| Answer::load(&patch.with_file_name("answer.json")).ok());
    let Some(answer) = beside.into_iter().chain([Answer::block()]).find(|answer| answer.is_for(scene)) else { return Vec::new() };
    let centre = answer.holds.first().map(|hold| hold.place_m);
    let centred = answer.holds.iter().filter(|hold| Some(hold.place_m) == centre);
    let mut forces: Vec<_> = centred.map(|h| (h.depth_m, h.force_over_e_m2 * scene.tissue.youngs_modulus_pa)).collect();
    forces.sort_by(|a, b| a.0.total_cmp(&b.0));
    forces
}

/// Force of the stored answer at a hold of a scene that is driven by depth [N].
#[must_use]
pub fn at(scene: &Scene, target_m: f64) -> Option<f64> {
    let of_depth = matches!(scene.drive, Drive::Depth { .. });
    let near = |depth: f64| of_depth && (depth - target_m).abs() < SAME * depth;
    of(scene).into_iter().find(|(depth, _)| near(*depth)).map(|(_, force_n)| force_n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_beside_the_patch_comes_first_if_it_is_for_the_scene() {
        let folder = tempfile::tempdir().unwrap();
        let mut scene = Scene::load("block").unwrap();
        let shipped_n = at(&scene, 4e-3).unwrap();
        scene.solver.patch = Some(folder.path().join("fitted.patch"));
        let store = |change: &dyn Fn(&mut Answer)| {
            let mut answer = Answer::block();
            answer.holds.iter_mut().for_each(|hold| hold.force_over_e_m2 *= 2.0);
            change(&mut answer);
            std::fs::write(folder.path().join("answer.json"), serde_json::to_string(&answer).unwrap()).unwrap();
        };
        store(&|_| ());
        assert_eq!(at(&scene, 4e-3), Some(2.0 * shipped_n));
        store(&|answer| answer.tissue.poisson_ratio = 0.3);
        assert_eq!(at(&scene, 4e-3), Some(shipped_n));
    }
}
