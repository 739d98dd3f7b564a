//! A patch that tells the loop how stiff it is, so that the loop brings it to what the device
//! renders.

use palpate::haptic::cycle::{PatchRenderer, Renderer};
use palpate::stages::probe::{ProbePose, continuation_m};
use palpate::{Output, Params};

use crate::faults::paths::PathPatch;

/// Number of depths at which the stiffness of a patch is taken.
const DEPTHS: u32 = 100;
/// Step for the slope of the static force [m].
const STEP_M: f64 = 0.25e-3;

/// A patch with the stiffness that it reports.
pub(super) struct Measured<'a, 'm> {
    pub patch: PatchRenderer<'a, 'm>,
    pub stiffness_n_per_m: f32,
}

impl Renderer for Measured<'_, '_> {
    fn render(&mut self, pose: ProbePose) -> Output {
        self.patch.render(pose)
    }

    fn reset(&mut self) {
        self.patch.reset();
    }

    fn stiffness_n_per_m(&self) -> f32 {
        self.stiffness_n_per_m
    }
}

/// The stiffest static slope of a patch down to the depth limit and beyond it [N/m].
pub(super) fn stiffest_n_per_m(on: &PathPatch, params: &Params, limit_m: f64) -> f32 {
    let youngs_modulus_pa = f64::from(params.youngs_modulus_pa);
    let force_n = |depth_m: f64| on.force_n(youngs_modulus_pa, depth_m);
    let slope_n_per_m = |depth_m: f64| (force_n(depth_m) - force_n(depth_m - STEP_M)) / STEP_M;
    let depths_m = (1..DEPTHS).map(|n| limit_m * f64::from(n) / f64::from(DEPTHS));
    let beyond_m = continuation_m(&params.probe, params.poisson_ratio, limit_m as f32);
    depths_m.map(slope_n_per_m).fold(f64::from(beyond_m) * youngs_modulus_pa, f64::max) as f32
}
