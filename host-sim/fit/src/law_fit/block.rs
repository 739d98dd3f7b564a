//! The law of a block: its answers, and the motions that judge it.

use palpate::Params;
use serde::Serialize;

use super::{LawTask, block_shape, branches};
use crate::force_map::BlockForces;
use palpate_tissue::answer::Answer;
use palpate_tissue::error::Error;
use palpate_tissue::moving::{CourseError, Ramp, Site, TRUTHS, Trajectory, Truth};
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::Scene;

/// Depths of the stored answer that a law is fitted to [m]; at the others it is judged.
const FITTED_M: [f64; 5] = [5e-4, 1e-3, 2e-3, 4e-3, 8e-3];
/// Deepest press of the stored answer for which a law is fitted and judged [m].
const DEEPEST_M: f64 = 8e-3;
/// Fastest ramp that branches are fitted to [mm/s].
const MOST_MM_PER_S: u32 = 200;
/// Radius of the disc of places [probe radii].
pub const REACH_RADII: f64 = 1.65;

/// Error of a law along a stored motion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotionError {
    /// Name of the motion.
    pub name: String,
    /// Whether the branches were fitted to it.
    pub fitted: bool,
    /// Root mean square of the error, relative to the largest reference force [%]: of a ramp until
    /// 20 ms after its stop.
    pub rms_pct: f64,
}

/// Splits the stored answer of the preset block, if it is that of the scene: depths that a law is
/// fitted to, and presses that it does not see.
#[must_use]
pub fn stored(scene: &Scene) -> Option<(Answer, Answer, Vec<f64>)> {
    let answer = Some(Answer::block()).filter(|answer| answer.is_for(scene))?;
    let (mut known, mut unseen) = (answer.clone(), answer);
    let fitted = |depth_m: f64| FITTED_M.iter().any(|m| (m - depth_m).abs() < 1e-7);
    known.holds.retain(|hold| fitted(hold.depth_m));
    unseen.holds.retain(|hold| !fitted(hold.depth_m) && hold.depth_m <= DEEPEST_M && hold.place_m[0] <= REACH_RADII * scene.probe.radius_m);
    unseen.holds.iter_mut().for_each(|hold| hold.surface = None);
    unseen.glued.clear();
    Some((known, unseen, FITTED_M.to_vec()))
}

/// The stored motions of a scene's tissue, whatever its Young's modulus, centred or not.
fn truths(scene: &Scene) -> Vec<Truth> {
    let own = |truth: &Truth| {
        truth.scene().is_ok_and(|mut of| {
            of.tissue.youngs_modulus_pa = scene.tissue.youngs_modulus_pa;
            of.probe.position_m = scene.probe.position_m;
            of.tissue.nodes = scene.tissue.nodes;
            of.tissue == scene.tissue && of.probe == scene.probe
        })
    };
    TRUTHS.into_iter().filter(own).collect()
}

/// Whether branches are fitted to a motion: a centred ramp, not the fastest, in the softest or the
/// stiffest tissue.
fn is_fitted(truth: &Truth, all: &[Truth]) -> bool {
    let moduli = || all.iter().map(|truth| truth.youngs_modulus_pa);
    let end = |pa: f64| pa == moduli().fold(f64::INFINITY, f64::min) || pa == moduli().fold(0.0, f64::max);
    let slow = matches!(truth.trajectory, Trajectory::Ramp { speed_mm_per_s, .. } if speed_mm_per_s <= MOST_MM_PER_S);
    truth.site == Site::Centre && slow && end(truth.youngs_modulus_pa)
}

/// Fits the law of a block with the forces `known` at `depths_m`.
///
/// # Errors
/// The forces lack places or depths, or a stored ramp cannot be read.
pub fn fit(scene: &Scene, size_m: [f64; 3], known: &BlockForces, depths_m: &[f64]) -> Result<(Patch, Params), Error> {
    let params = scene.params([0.0, 0.0, 1.0]);
    let [x, y] = scene.probe.position_m.unwrap_or_default();
    let deepest_m = depths_m.last().copied().unwrap_or_default();
    let rest = block_shape(size_m, [x, y, 0.0], deepest_m);
    let reach_m = REACH_RADII * scene.probe.radius_m;
    let task = LawTask { known, depths_m, reach_m, side: 1, axis: params.probe.axis.cast(), site_m: rest.site_m };
    let mut law = task.fit(&params)?;
    let all = truths(scene);
    let ramps = all.iter().filter(|truth| is_fitted(truth, &all)).map(|truth| Ramp::of(*truth));
    let ramps = ramps.collect::<Result<Vec<_>, _>>()?;
    if let Some(row) = law.table.first().filter(|_| !ramps.is_empty()) {
        law.shape.branches = branches(row, &ramps, &params)?;
    }
    let mut patch = Patch::of_law(&rest, scene.tissue.poisson_ratio, law);
    patch.set_fitted_places(super::held::PLACES as u32);
    Ok((patch, params))
}

/// Errors of a patch along every stored motion of its scene.
///
/// # Errors
/// A motion cannot be read, or the core refuses the patch.
pub fn motions(scene: &Scene, patch: &Patch, params: &Params) -> Result<Vec<MotionError>, Error> {
    let all = truths(scene);
    let mut errors = Vec::new();
    for truth in &all {
        let place_m = truth.scene()?.probe.position_m.unwrap_or_default();
        let mut site_m = patch.site_m();
        (site_m.x, site_m.y) = (place_m[0] as f32, place_m[1] as f32);
        let rms_pct = match truth.trajectory {
            Trajectory::Ramp { .. } => Ramp::of(*truth)?.judge_patch(patch, params, site_m)?.map(|error| error.rms_pct),
            _ => CourseError::of(truth, patch, params, site_m)?.map(|error| error.rms_pct),
        };
        let name = truth.name.to_owned();
        errors.push(MotionError { name, fitted: is_fitted(truth, &all), rms_pct: rms_pct.unwrap_or(f64::INFINITY) });
    }
    Ok(errors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene_fit::{Judging, PLACES};
    use palpate_tissue::budget::MACHINES;
    use palpate_tissue::session::Session;

    #[test]
    fn a_law_of_the_block_holds_where_and_as_it_was_not_fitted() {
        let scene = Scene::load("block").unwrap();
        let (known, unseen, depths_m) = stored(&scene).unwrap();
        let known = BlockForces::of(&known).unwrap();
        let (patch, params) = fit(&scene, scene.tissue.block_m.unwrap(), &known, &depths_m).unwrap();
        println!("{:?}", patch.model().law);
        let all = BlockForces::of(&Answer::block()).unwrap();
        let session = Session::of_fitted(&MACHINES[0], patch, params).unwrap();
        let judging = Judging { known: &all, fitted_m: &depths_m, unseen: &unseen, disc_radii: 1.5, places: PLACES };
        let verdict = judging.judge(&session).unwrap();
        println!("{verdict:?}");
        let motions = motions(&scene, &session.patch, &session.params).unwrap();
        motions.iter().for_each(|m| println!("{} {} {:.2}", m.name, m.fitted, m.rms_pct));
        assert!(verdict.rms_pct() < 1.0 && verdict.worst_pct().abs() < 2.0 && verdict.lost_presses == 0);
        assert!(motions.len() == 27);
    }
}
