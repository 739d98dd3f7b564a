//! Stored motions: those that the branches of a law are fitted to, and those that judge it.

use palpate::Params;
use serde::Serialize;

use palpate_tissue::error::Error;
use palpate_tissue::moving::{CourseError, Ramp, Site, TRUTHS, Trajectory, Truth};
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::Scene;

/// Fastest ramp that branches are fitted to [mm/s].
const MOST_MM_PER_S: u32 = 200;

/// Error of a law along a stored motion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotionError {
    /// Name of the motion.
    pub name: String,
    /// Largest speed [mm/s].
    pub mm_per_s: u32,
    /// Whether the branches were fitted to it.
    pub fitted: bool,
    /// Root mean square of the error, relative to the largest reference force [%]: of a ramp until
    /// 20 ms after its stop.
    pub rms_pct: f64,
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

/// The ramps that the branches of a scene's law are fitted to; empty if none is stored.
///
/// # Errors
/// A stored ramp cannot be read.
pub(super) fn ramps(scene: &Scene) -> Result<Vec<Ramp>, Error> {
    let all = truths(scene);
    let ramps = all.iter().filter(|truth| is_fitted(truth, &all)).map(|truth| Ramp::of(*truth));
    Ok(ramps.collect::<Result<Vec<_>, _>>()?)
}

/// Errors of a patch along every stored motion of its scene.
///
/// # Errors
/// A motion cannot be read, or the core refuses the patch.
pub fn errors(scene: &Scene, patch: &Patch, params: &Params) -> Result<Vec<MotionError>, Error> {
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
        let mm_per_s = truth.trajectory.speed_mm_per_s();
        errors.push(MotionError { name, mm_per_s, fitted: is_fitted(truth, &all), rms_pct: rms_pct.unwrap_or(f64::INFINITY) });
    }
    Ok(errors)
}
