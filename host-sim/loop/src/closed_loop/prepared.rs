//! A scene prepared for a device: how deep it may be pressed, how many substeps a tap needs, and up
//! to which stiffness the encoder is fine enough.

use palpate::haptic::ceiling;
use palpate::{GuardLimits, Params};

use super::device::DeviceProfile;
use super::fidelity::{self, TAPS};
use super::stimulus::CLEAR_M;
use super::surface::{depth_at_m, force_at_n, static_curve, tangent_m};
use super::verdict::FELT_N;
use palpate_tissue::error::Error;
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::{Scene, TICK_S};
use palpate_tissue::session::Session;
use palpate_tissue::stable_step::substeps_for_fast_taps;

/// Largest depth at which a press may rest [m].
pub const DEPTH_M: f64 = 4e-3;
/// Largest share of the loop's maximum force at which a press may rest (1); saturation has its own
/// runs.
pub const FORCE_SHARE: f64 = 0.85;
/// The guard limits the depth to that at which the static force is this many times the largest
/// permitted force (1).
pub const GUARD_SHARE: f64 = 1.09;
/// Smallest depth at which a press may rest [m].
const SHALLOWEST_M: f64 = 0.25e-3;
/// Sideways distance of a drag [m].
const ASIDE_M: f64 = 8e-3;

/// A patch that was prepared for a device.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The patch, with the depth limit of the guard.
    pub patch: Patch,
    /// Parameters, with the substeps that answer taps.
    pub params: Params,
    /// RMS error of taps at 0.2 and 0.5 m/s (1); NaN where the mesh has no reference with true
    /// masses.
    pub tap_errors: [f64; TAPS.len()],
    /// Smallest volume of a tet in a tap as deep as the tissue may be pressed, relative to its rest
    /// volume (1).
    pub lowest_j: f64,
    /// Whether every tap is within its limit and crushes no tet.
    pub taps_held: bool,
    /// Whether the tissue stays stable under taps of 1 m/s; true for tissue that does not stiffen.
    pub fast_taps_held: bool,
    /// Whether the substeps were chosen to answer taps; a patch for a board keeps its own.
    pub substeps_chosen: bool,
    /// Static force over depth [m, N].
    pub curve: Vec<(f64, f64)>,
    /// Depth at which presses rest [m].
    pub depth_m: f64,
    /// Force at that depth [N].
    pub static_n: f64,
    /// Slope at that depth [N/m].
    pub slope_n_per_m: f64,
    /// Stiffness of the contact at the depth limit [N/m].
    pub contact_n_per_m: f64,
    /// Gain with which the loop keeps this contact at the device's stiffness ceiling (1).
    pub ceiling_gain: f64,
}

impl Prepared {
    /// Prepares a scene for a device.
    ///
    /// # Errors
    /// Fails if the input is invalid, or if the model cannot keep 1 kHz.
    pub fn of(scene: &Scene, device: &DeviceProfile) -> Result<Self, Error> {
        Self::prepare(scene, device, true)
    }

    /// Prepares a scene for a device with the substeps that the patch was packed with: those that a
    /// board computes in a tick.
    ///
    /// # Errors
    /// Errors of [`Self::of`].
    pub fn as_packed(scene: &Scene, device: &DeviceProfile) -> Result<Self, Error> {
        Self::prepare(scene, device, false)
    }

    fn prepare(scene: &Scene, device: &DeviceProfile, choose_substeps: bool) -> Result<Self, Error> {
        let session = Session::prepare(scene)?;
        let fitted_for = scene.solver.patch.is_some();
        let deepest_m = if fitted_for { f64::from(session.patch.model().depth_limit_m) } else { scene.probe.radius_m };
        Self::with(session.patch, &session.params, deepest_m, device, choose_substeps)
    }

    /// Note on a contact that the loop weakens; `None` if the device renders it as it is.
    #[must_use]
    pub fn ceiling_note(&self) -> Option<String> {
        ceiling_note(self.contact_n_per_m as f32, (self.ceiling_gain * self.contact_n_per_m) as f32)
    }

    /// Sets the depth at which presses rest [m].
    ///
    /// # Errors
    /// [`Error::Usage`]: deeper than the device's force limit allows, or hardly touching.
    pub fn press_to(&mut self, depth_m: f64) -> Result<(), Error> {
        if !(SHALLOWEST_M..=self.depth_m).contains(&depth_m) {
            let ends =
                if self.depth_m < DEPTH_M { "deeper, the force exceeds the device's limit" } else { "hands press no deeper" };
            return Err(Error::Usage(format!(
                "--depth: {} mm is outside {:.2} to {:.2} mm ({ends}): give a depth in that range, such as 3mm",
                1e3 * depth_m,
                1e3 * SHALLOWEST_M,
                1e3 * self.depth_m
            )));
        }
        (self.static_n, self.slope_n_per_m) = rest(&self.curve, depth_m);
        self.depth_m = depth_m;
        Ok(())
    }

    /// Prepares a patch that is pressed to `deepest_m` at most.
    ///
    /// # Errors
    /// Fails if the workspace is too small for the stimuli, or if the core rejects the parameters.
    pub fn of_patch(patch: Patch, params: &Params, deepest_m: f64, device: &DeviceProfile) -> Result<Self, Error> {
        Self::with(patch, params, deepest_m, device, true)
    }

    /// Prepares a patch that is pressed to its own depth limit at most, with the substeps in
    /// `params`.
    ///
    /// # Errors
    /// Errors of [`Self::of_patch`].
    pub fn of_fitted(patch: Patch, params: &Params, device: &DeviceProfile) -> Result<Self, Error> {
        let deepest_m = f64::from(patch.model().depth_limit_m);
        Self::with(patch, params, deepest_m, device, false)
    }

    fn with(
        mut patch: Patch,
        params: &Params,
        deepest_m: f64,
        device: &DeviceProfile,
        substeps_chosen: bool,
    ) -> Result<Self, Error> {
        fits(device, deepest_m)?;
        patch.set_depth_limit_m(deepest_m as f32);
        let one = Params { substeps: 1, ..*params };
        let curve = static_curve(&patch, params)?;
        let depth_m = depth_at_m(&curve, FORCE_SHARE * device.force_limit_n).min(DEPTH_M);
        let fidelity = match substeps_chosen {
            true => fidelity::derive(&patch, &one, depth_m)?,
            false => fidelity::as_it_is(&patch, params, depth_m)?,
        };
        // without a reference the substeps of the session are used
        let params = if fidelity.errors.iter().any(|e| e.is_nan()) { *params } else { fidelity.params };
        let curve = static_curve(&patch, &params)?;
        patch.set_depth_limit_m(depth_at_m(&curve, GUARD_SHARE * device.force_limit_n) as f32);
        // taps are checked again: these masses are lighter than the session's, and the limit may be
        // deeper
        let substeps = match substeps_chosen {
            true => substeps_for_fast_taps(&patch.wide_model(), &params, patch.site_m(), params.substeps)?,
            false => Some(params.substeps),
        };
        // beyond the guard's depth the force does not rise: the device sends no more
        let most_n = (GUARD_SHARE * device.force_limit_n) as f32;
        let limits = GuardLimits { max_force_n: most_n.min(params.limits.max_force_n), ..params.limits };
        let raised = Params { substeps: substeps.unwrap_or(params.substeps), limits, ..params };
        let has_reference = fidelity.errors.iter().all(|e| e.is_finite());
        let fidelity = match has_reference && raised.substeps > params.substeps {
            true => fidelity::as_it_is(&patch, &raised, depth_m)?,
            false => fidelity,
        };
        let (static_n, slope_n_per_m) = rest(&curve, depth_m);
        let contact_n_per_m = f64::from(tangent_m(&patch, &raised)? * raised.youngs_modulus_pa);
        let ceiling_n_per_m = device.limits(palpate::Vector3::zeros()).ceiling_n_per_m(TICK_S as f32);
        let ceiling_gain = f64::from(ceiling::gain(contact_n_per_m as f32, ceiling_n_per_m));
        Ok(Self {
            patch,
            params: raised,
            tap_errors: fidelity.errors,
            lowest_j: fidelity.lowest_j,
            taps_held: fidelity.held,
            fast_taps_held: substeps.is_some(),
            substeps_chosen,
            curve,
            depth_m,
            static_n,
            slope_n_per_m,
            contact_n_per_m,
            ceiling_gain,
        })
    }
}

/// Note on a contact of this stiffness that the loop weakens on a device with this ceiling [N/m];
/// `None` if the device renders it as it is.
#[must_use]
pub fn ceiling_note(contact_n_per_m: f32, ceiling_n_per_m: f32) -> Option<String> {
    let gain = ceiling::gain(contact_n_per_m, ceiling_n_per_m);
    (gain < 1.0).then(|| {
        format!(
            "the contact is {contact_n_per_m:.0} N/m stiff at the depth limit, and the device renders {ceiling_n_per_m:.0} N/m (stiffness_ceiling_n_per_m): the hand feels {:.0} % of every force (flag GAIN)",
            100.0 * gain
        )
    })
}

/// Force [N] and slope [N/m] at a depth.
fn rest(curve: &[(f64, f64)], depth_m: f64) -> (f64, f64) {
    let (static_n, h_m) = (force_at_n(curve, depth_m), SHALLOWEST_M);
    (static_n, (static_n - force_at_n(curve, depth_m - h_m)) / h_m)
}

/// Stiffness up to which one count of the encoder is not felt [N/m]: the device's friction hides
/// its force in both directions, or the force is too weak to be felt when the count toggles. Above
/// this stiffness no count balances the hand at some depths.
#[must_use]
pub fn encoder_ceiling_n_per_m(device: &DeviceProfile) -> f64 {
    if device.count_m > 0.0 { 2.0 * device.friction_n.max(FELT_N) / device.count_m } else { f64::INFINITY }
}

/// Checks that every stimulus stays within the workspace.
///
/// # Errors
/// [`Error::Usage`] names the excess.
pub fn fits(device: &DeviceProfile, deepest_m: f64) -> Result<(), Error> {
    // half as much again, since a hand overshoots
    let least_m = 3.0 * CLEAR_M.max(deepest_m).max(ASIDE_M);
    let sides: &[f64] = if device.axes == 1 { &device.workspace_m[2..] } else { &device.workspace_m };
    match sides.iter().find(|side| **side < least_m) {
        None => Ok(()),
        Some(side) => Err(Error::Usage(format!(
            "device {}: the stimuli leave its workspace: a side is {:.0} mm, they need {:.0} mm: give a larger workspace_m or press less deep",
            device.name,
            side * 1e3,
            least_m * 1e3
        ))),
    }
}
