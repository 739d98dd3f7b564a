//! A patch that is scaled down to the stiffness that its device can render.

use palpate::haptic::cycle::Renderer;
use palpate::stages::probe::ProbePose;
use palpate::{Output, Params};

use crate::closed_loop::device::DeviceProfile;
use crate::closed_loop::paths::PathPatch;

/// Number of depths at which the stiffness of a patch is taken.
const DEPTHS: u32 = 100;
/// Largest change of the force by one count [N].
const COUNT_N: f64 = 0.06;
/// Step for the slope of the static force [m].
const STEP_M: f64 = 0.25e-3;

/// A renderer whose force is scaled.
pub(super) struct Scaled<R> {
    pub inner: R,
    /// Factor of the force (1).
    pub gain: f32,
}

impl<R: Renderer> Renderer for Scaled<R> {
    fn render(&mut self, pose: ProbePose) -> Output {
        let output = self.inner.render(pose);
        Output { force_n: output.force_n * self.gain, grip_n: output.grip_n * self.gain, ..output }
    }

    fn reset(&mut self) {
        self.inner.reset();
    }
}

/// Factor (1) that brings the stiffest static slope of the patch, down to the depth limit [m], to
/// the device's ceiling, or to that of its counts if it is lower.
pub(super) fn gain(on: &PathPatch, params: &Params, device: &DeviceProfile, limit_m: f64) -> f32 {
    let youngs_modulus_pa = f64::from(params.youngs_modulus_pa);
    let force_n = |depth_m: f64| on.force_n(youngs_modulus_pa, depth_m);
    let slope_n_per_m = |depth_m: f64| (force_n(depth_m) - force_n(depth_m - STEP_M)) / STEP_M;
    let depths_m = (1..DEPTHS).map(|n| limit_m * f64::from(n) / f64::from(DEPTHS));
    let stiffest_n_per_m = depths_m.map(slope_n_per_m).fold(1.0, f64::max);
    let of_counts_n_per_m = if device.count_m > 0.0 { COUNT_N / device.count_m } else { f64::INFINITY };
    (device.stiffness_ceiling_n_per_m.min(of_counts_n_per_m) / stiffest_n_per_m).min(1.0) as f32
}
