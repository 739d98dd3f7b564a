//! Moving error of a patch for which no dynamic reference is stored: the deviation from the same
//! patch with much shorter substeps.
//!
//! The mass floor falls with the square of the substep, so that with many substeps the patch moves
//! with almost its true masses. The deviation does not include errors that both runs share, above
//! all those of the mesh: 3 % of the peak on the shipped patches up to 200 mm/s, more in faster
//! taps.

use palpate::{GuardLimits, Params, ProbePose, Vector3, tick};

use crate::error::Error;
use crate::patch::{Memory, Patch};
use crate::scene::TICK_S;

/// Number of substeps of the reference, over that of the patch.
const FINER: u16 = 12;
/// Ticks above the surface before the ramp.
const LEAD_TICKS: i32 = 5;

/// Multiplies the number of substeps by `times`. The mass floor is that of the shorter substep,
/// lower by the square of `times`; the largest speed at which the probe may sink is multiplied by
/// `times`.
#[must_use]
pub fn with_substeps(params: &Params, times: u16) -> Params {
    let n = f32::from(times);
    let max_sink_m_per_s = (params.limits.max_sink_m_per_s * n).min(GuardLimits::HIGHEST.max_sink_m_per_s);
    Params {
        substeps: params.substeps.saturating_mul(times),
        mass_floor: params.mass_floor / (n * n),
        limits: GuardLimits { max_sink_m_per_s, ..params.limits },
        ..*params
    }
}

/// A straight approach to a depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Place of the surface above which the tip starts [m].
    pub site_m: Vector3<f32>,
    /// Speed of the tip [m/s].
    pub speed_m_per_s: f64,
    /// Depth at which the approach ends [m].
    pub depth_m: f64,
}

/// Forces of a patch with almost true masses, with which other runs are compared.
#[derive(Clone, Debug)]
pub struct SelfCheck {
    approach: Approach,
    force_n: Vec<f64>,
    largest_n: f64,
}

impl SelfCheck {
    /// Runs a patch with much shorter substeps as the reference. `None` if it does not survive the
    /// approach or gives no force.
    ///
    /// # Errors
    /// Fails if the core rejects the model.
    pub fn of(patch: &Patch, params: &Params, approach: Approach) -> Result<Option<Self>, Error> {
        let Some(force_n) = press(patch, &with_substeps(params, FINER), approach)? else { return Ok(None) };
        let largest_n = force_n.iter().copied().fold(0.0, f64::max);
        Ok((largest_n > 0.0).then_some(Self { approach, force_n, largest_n }))
    }

    /// Root mean square error of the same patch with other substeps, relative to the reference's
    /// largest force [%]. `None` if it does not survive the approach.
    ///
    /// # Errors
    /// Fails if the core rejects the model.
    pub fn rms_pct(&self, patch: &Patch, params: &Params) -> Result<Option<f64>, Error> {
        let Some(own_n) = press(patch, params, self.approach)? else { return Ok(None) };
        let squares: f64 = own_n.iter().zip(&self.force_n).map(|(a, b)| (a - b).powi(2)).sum();
        Ok(Some((squares / own_n.len() as f64).sqrt() / self.largest_n * 100.0))
    }
}

/// Force along the press after every tick of an approach [N]; `None` if a fault ends the approach.
fn press(patch: &Patch, params: &Params, approach: Approach) -> Result<Option<Vec<f64>>, Error> {
    let Approach { site_m, speed_m_per_s, depth_m } = approach;
    let model = patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, params)?;
    let axis = params.probe.axis;
    let step_m = speed_m_per_s * TICK_S;
    let ticks = (depth_m / step_m).ceil() as i32;
    let mut force_n = Vec::new();
    for n in -LEAD_TICKS..=ticks {
        let depth_m = (step_m * f64::from(n)).min(depth_m);
        let out = tick(&model, &tuned, &mut state, ProbePose { tip_m: site_m - axis * depth_m as f32 });
        if out.fault.is_some() {
            return Ok(None);
        }
        if n > 0 {
            force_n.push(f64::from(out.force_n.dot(&axis)));
        }
    }
    Ok(Some(force_n))
}
