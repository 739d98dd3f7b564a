//! Force error along any stored motion: ramps, taps that return, swings and drags.

use palpate::{Fault, Params, ProbePose, Vector3, tick};
use serde::Serialize;

use super::truth::Truth;
use crate::error::Error;
use crate::patch::{Memory, Patch};

/// Ticks above the surface before the motion begins, at the initial speed of the motion.
const LEAD_TICKS: i32 = 5;

/// Force error over a whole motion, including the pauses in it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CourseError {
    /// Root mean square of the error along the press, relative to the largest reference force [%].
    pub rms_pct: f64,
    /// Root mean square of the error across the press, relative to the largest reference force [%].
    pub across_rms_pct: f64,
    /// Error of the largest force along the press [%].
    pub peak_pct: f64,
}

impl CourseError {
    /// Moves the probe on a patch as in the reference, one pose per tick, and compares the forces
    /// after every tick. `site_m` is the reference's place on this patch, in the frame of the block
    /// [m].
    ///
    /// # Errors
    /// Fails if the reference cannot be read, or if the core rejects the model; the inner error is
    /// the fault of a patch that does not survive the motion.
    pub fn of(truth: &Truth, patch: &Patch, params: &Params, site_m: Vector3<f32>) -> Result<Result<Self, Fault>, Error> {
        let table = truth.stored()?;
        let model = patch.wide_model();
        let mut memory = Memory::for_model(&model);
        let params = Params { youngs_modulus_pa: truth.youngs_modulus_pa as f32, ..*params };
        let (tuned, mut state) = memory.start(&model, &params)?;
        let axis = params.probe.axis;
        let seconds = |n: i32| f64::from(n) * f64::from(params.tick_s);
        let last = (table.rows.last().map_or(0.0, |row| row.t_s) / f64::from(params.tick_s)).round() as i32;
        let first = table.at(seconds(1));
        let (mut along, mut across, mut peak_m2, mut true_peak_m2) = (0.0, 0.0, 0.0_f64, 0.0_f64);
        for n in -LEAD_TICKS..=last {
            let row = table.at(seconds(n));
            let depth_m = if n < 0 { f64::from(n) * first.depth_m } else { row.depth_m };
            let tip_m = site_m - axis * depth_m as f32 + Vector3::x() * row.across_m as f32;
            let out = tick(&model, &tuned, &mut state, ProbePose { tip_m });
            if let Some(fault) = out.fault {
                return Ok(Err(fault));
            }
            if n <= 0 {
                continue;
            }
            let own = out.force_n.cast::<f64>() / truth.youngs_modulus_pa;
            let [x, y, wanted] = row.force_over_e_m2;
            let normal = own.dot(&axis.cast());
            along += (normal - wanted).powi(2);
            across += (own.x - x).powi(2) + (own.y - y).powi(2);
            (peak_m2, true_peak_m2) = (peak_m2.max(normal), true_peak_m2.max(wanted));
        }
        let rms_pct = |sum: f64| (sum / f64::from(last)).sqrt() / true_peak_m2 * 100.0;
        Ok(Ok(Self {
            rms_pct: rms_pct(along),
            across_rms_pct: rms_pct(across),
            peak_pct: (peak_m2 / true_peak_m2 - 1.0) * 100.0,
        }))
    }
}
