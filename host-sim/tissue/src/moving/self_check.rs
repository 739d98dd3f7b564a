//! Moving error of a patch without a dynamic reference: relative to the same patch with much
//! shorter substeps.
//!
//! The mass floor falls with the square of the substep, so with many substeps the patch moves with
//! almost its true masses. It does not include the errors that both share, above all those of the
//! mesh: 3 % of the peak on the shipped patches up to 200 mm/s, more in faster taps.

use palpate::{GuardLimits, Params, ProbePose, Vector3, tick};

use crate::error::Error;
use crate::patch::{Memory, Patch};
use crate::scene::TICK_S;

/// Ratio of the reference's substeps to the patch's.
const FINER: u16 = 12;
/// Ticks above the surface before the ramp.
const LEAD_TICKS: i32 = 5;

/// Multiplies the substeps, with the masses floored for the shorter substep: lighter by the square
/// of that factor. The probe may sink faster by that factor.
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
    /// Speed [m/s].
    pub speed_m_per_s: f64,
    /// Depth at which it ends [m].
    pub depth_m: f64,
}

/// Forces of a patch with almost true masses, to which others are compared.
#[derive(Clone, Debug)]
pub struct SelfCheck {
    approach: Approach,
    force_n: Vec<f64>,
    largest_n: f64,
}

impl SelfCheck {
    /// Presses the reference of a patch. `None` if it does not survive the approach or gives no
    /// force.
    ///
    /// # Errors
    /// A model that the core refuses.
    pub fn of(patch: &Patch, params: &Params, approach: Approach) -> Result<Option<Self>, Error> {
        let Some(force_n) = press(patch, &with_substeps(params, FINER), approach)? else { return Ok(None) };
        let largest_n = force_n.iter().copied().fold(0.0, f64::max);
        Ok((largest_n > 0.0).then_some(Self { approach, force_n, largest_n }))
    }

    /// Root mean square error of the same patch with other substeps, relative to the reference's
    /// largest force [%]. `None` if it does not survive the approach.
    ///
    /// # Errors
    /// A model that the core refuses.
    pub fn rms_pct(&self, patch: &Patch, params: &Params) -> Result<Option<f64>, Error> {
        let Some(own_n) = press(patch, params, self.approach)? else { return Ok(None) };
        let squares: f64 = own_n.iter().zip(&self.force_n).map(|(a, b)| (a - b).powi(2)).sum();
        Ok(Some((squares / own_n.len() as f64).sqrt() / self.largest_n * 100.0))
    }
}

/// Force along the press after every tick of an approach [N].
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
