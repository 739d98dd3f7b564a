//! Finds the number of substeps with which a patch answers a tap with the inertia of the tissue,
//! not with that of the floored masses.
//!
//! The mass floor keeps one step per millisecond stable; it does not affect statics, but it does
//! affect a tap. With `n` substeps and the floor of the *substep*, the added mass is `n^2` times
//! smaller. The gain is measured when a patch is prepared: half-sine taps are compared with those
//! on the same patch with true masses, in steps so small that it needs no floor.

use palpate::stages::probe::ProbePose;
use palpate::{BuildError, GuardLimits, Params, tick};

use palpate_tissue::measure::volumes;
use palpate_tissue::moving::with_substeps;
use palpate_tissue::patch::{Memory, Patch};
use palpate_tissue::stable_step::StableStep;

/// Speeds of the taps [m/s] and the RMS error allowed, as a share of the largest force (1). 5 and
/// 10 % would be enough for the taps; a closer fit also weakens the kick of a single encoder count,
/// which comes from the floored masses.
pub const TAPS: [(f64, f64); 2] = [(0.2, 0.02), (0.5, 0.075)];
/// Smallest volume that a tet may have in any tap, relative to its rest volume (1): a tet between
/// heavy neighbours is easily crushed.
pub const LEAST_J: f64 = 0.2;
/// Numbers of substeps that are tried.
const TRIED: [u16; 8] = [1, 2, 3, 4, 6, 8, 12, 16];
/// Largest number of substeps with true masses; a mesh with a sliver that needs more has no
/// reference.
const MOST_TRUE: f64 = 4000.0;

/// Substeps of a patch, and the resulting errors.
#[derive(Clone, Copy, Debug)]
pub struct Fidelity {
    /// Parameters with these substeps and the masses for them.
    pub params: Params,
    /// RMS error of each of [`TAPS`] (1).
    pub errors: [f64; TAPS.len()],
    /// Smallest volume of a tet in the deepest tap, relative to its rest volume (1).
    pub lowest_j: f64,
    /// Whether every tap is within its limit, and no tap crushes a tet.
    pub held: bool,
}

/// Finds the smallest number of substeps with which the patch answers [`TAPS`] to `depth_m` within
/// the limits; if none does, uses the largest number tried. `params` must be for one substep.
///
/// # Errors
/// Propagates errors from [`Params::build`].
pub fn derive(patch: &Patch, params: &Params, depth_m: f64) -> Result<Fidelity, BuildError> {
    let answers = true_answers(patch, params, depth_m)?;
    let mut last = None;
    for n in TRIED {
        let tried = with_substeps(params, n);
        if StableStep::measure(&patch.wide_model(), &tried, patch.site_m())?.is_none_or(|s| s.substeps(1e-3) > f64::from(n)) {
            continue;
        }
        let judged = judge(patch, &tried, depth_m, &answers)?;
        last = Some(judged);
        if judged.held {
            break;
        }
    }
    Ok(last.unwrap_or(Fidelity { params: *params, errors: [f64::NAN; TAPS.len()], lowest_j: f64::NAN, held: false }))
}

/// Returns the fidelity of a patch with the substeps that it has.
///
/// # Errors
/// Propagates errors from [`Params::build`].
pub fn as_it_is(patch: &Patch, params: &Params, depth_m: f64) -> Result<Fidelity, BuildError> {
    judge(patch, params, depth_m, &true_answers(patch, &Params { substeps: 1, ..*params }, depth_m)?)
}

/// Forces of [`TAPS`] on the patch with true masses; empty if it has no reference.
fn true_answers(patch: &Patch, params: &Params, depth_m: f64) -> Result<Vec<Vec<f64>>, BuildError> {
    let Some(truth) = true_masses(patch, params)? else { return Ok(Vec::new()) };
    TAPS.iter().map(|(speed, _)| tap(patch, &truth, depth_m, *speed)).collect()
}

fn judge(patch: &Patch, tried: &Params, depth_m: f64, answers: &[Vec<f64>]) -> Result<Fidelity, BuildError> {
    let mut errors = [f64::NAN; TAPS.len()];
    for ((error, (speed, _)), truth) in errors.iter_mut().zip(TAPS).zip(answers) {
        *error = rms_error(&tap(patch, tried, depth_m, speed)?, truth);
    }
    let lowest_j = lowest_j(patch, tried)?;
    let held = errors.iter().zip(TAPS).all(|(e, (_, most))| *e <= most) && lowest_j > LEAST_J;
    Ok(Fidelity { params: *tried, errors, lowest_j, held })
}

/// Parameters without a mass floor, in steps short enough to be stable; `None` if there would be
/// too many steps.
fn true_masses(patch: &Patch, params: &Params) -> Result<Option<Params>, BuildError> {
    let bare = Params { mass_floor: 0.0, limits: GuardLimits::HIGHEST, ..*params };
    let mut n = 16_u16;
    while f64::from(n) <= MOST_TRUE {
        let tried = Params { substeps: n, ..bare };
        if StableStep::measure(&patch.wide_model(), &tried, patch.site_m())?.is_some_and(|s| s.substeps(1e-3) <= f64::from(n)) {
            return Ok(Some(tried));
        }
        n *= 2;
    }
    Ok(None)
}

/// Force along the press [N] of a half-sine tap with this speed at the touch, tick by tick.
fn tap(patch: &Patch, params: &Params, depth_m: f64, m_per_s: f64) -> Result<Vec<f64>, BuildError> {
    let model = patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, params)?;
    let axis = params.probe.axis;
    let mut at = |depth_m: f64| {
        let tip_m = patch.touch_m(params) - axis * depth_m as f32;
        f64::from(tick(&model, &tuned, &mut state, ProbePose { tip_m }).force_n.dot(&axis))
    };
    let half_s = depth_m * std::f64::consts::PI / m_per_s;
    let ticks = (half_s * 1e3).ceil() as i32;
    let depth = |n: i32| {
        let t = f64::from(n) * 1e-3;
        if n < 0 { m_per_s * t } else { depth_m * (std::f64::consts::PI * t / half_s).sin() }
    };
    Ok((-5..=ticks).map(|n| at(depth(n))).collect())
}

/// Smallest volume of a tet, relative to its rest volume (1), in any tick of the fastest tap to the
/// patch's depth limit, of a hold of 50 ms there, and of the retreat.
fn lowest_j(patch: &Patch, params: &Params) -> Result<f64, BuildError> {
    let model = patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, params)?;
    let step_m = TAPS.map(|t| t.0).into_iter().fold(0.0, f64::max) * 1e-3;
    let deepest_m = f64::from(model.depth_limit_m);
    let ticks = (deepest_m / step_m).ceil() as i32 + 50;
    let mut lowest_j = f64::INFINITY;
    let out = (deepest_m / step_m).ceil() as i32 + 50;
    let depths_m = (-2..=ticks).map(|n| f64::from(n) * step_m).chain((0..=out).map(|n| deepest_m - f64::from(n) * step_m));
    for depth_m in depths_m.map(|d| d.min(deepest_m)) {
        let tip_m = patch.touch_m(params) - params.probe.axis * depth_m as f32;
        tick(&model, &tuned, &mut state, ProbePose { tip_m });
        lowest_j = lowest_j.min(volumes(&model, &state).0);
    }
    Ok(lowest_j)
}

/// RMS difference, relative to the largest true force (1).
fn rms_error(found: &[f64], truth: &[f64]) -> f64 {
    let most = truth.iter().copied().fold(0.0, f64::max);
    let square: f64 = found.iter().zip(truth).map(|(a, b)| (a - b) * (a - b)).sum();
    (square / truth.len() as f64).sqrt() / most
}
