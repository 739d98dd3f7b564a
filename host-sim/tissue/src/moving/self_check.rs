//! Moving error of a patch for which no dynamic reference is stored: the deviation from the same
//! patch with much shorter substeps, in the worst of the motions that a hand makes.
//!
//! The mass floor falls with the square of the substep, so that with many substeps the patch moves
//! with almost its true masses. The deviation does not include errors that both runs share, above
//! all those of the mesh: 3 % of the peak on the shipped patches up to 200 mm/s, more in faster
//! taps.

use std::f64::consts::TAU;

use palpate::{GuardLimits, Params, ProbePose, Vector3, tick};

use crate::error::Error;
use crate::organ::tangents;
use crate::patch::{Memory, Patch};
use crate::scene::TICK_S;

/// Number of substeps of the reference, over that of the patch.
const FINER: u16 = 12;
/// Ticks above the surface before the motion.
const LEAD_TICKS: i32 = 5;
/// Ticks after a motion that are compared as well.
const AFTER_TICKS: usize = 20;
/// Place beside the site at which every motion is repeated [probe radii].
const BESIDE_RADII: [f64; 2] = [0.6, -0.35];
/// Frequency of a swing [Hz], and its mean depth as a share of the largest (1).
const SWING_HZ: f64 = 8.0;
const SWING_MEAN: f64 = 0.6;
/// Largest speeds of the approach before a swing or a drag, and of a drag [m/s].
const GENTLE_M_PER_S: f64 = 0.04;
const DRAG_M_PER_S: f64 = 0.06;

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

/// How a hand moves at a place: fastest and deepest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Place of the surface above which the tip starts [m].
    pub site_m: Vector3<f32>,
    /// Largest speed of the tip [m/s].
    pub speed_m_per_s: f64,
    /// Largest depth [m].
    pub depth_m: f64,
    /// Whether the hand also taps, swings and drags; otherwise it presses straight, stops, and
    /// turns.
    pub free: bool,
}

/// A motion of the hand: its name, and depth of the tip and displacement across after every tick
/// [m].
type Course = (&'static str, Vec<[f64; 2]>);

impl Approach {
    /// The motions that are tried, each with the 20 ms after it, in which floored masses are felt
    /// most.
    fn courses(&self) -> Vec<Course> {
        let (step_m, depth_m) = (self.speed_m_per_s * TICK_S, self.depth_m);
        let ramp = |to_m: f64, step_m: f64| {
            (-LEAD_TICKS..(to_m / step_m).ceil() as i32).map(move |n| step_m * f64::from(n)).chain([to_m]).collect::<Vec<f64>>()
        };
        let down = ramp(depth_m, step_m);
        let stop = down.iter().copied().chain([depth_m; AFTER_TICKS]);
        let turn = down.iter().copied().chain(down.iter().rev().copied());
        let straight = |tips: Vec<f64>| tips.into_iter().map(|depth_m| [depth_m, 0.0]).collect();
        let mut courses = vec![("stop", straight(stop.collect())), ("turn", straight(turn.collect()))];
        if self.free {
            let (mean_m, gentle_m) = (SWING_MEAN * depth_m, step_m.min(GENTLE_M_PER_S * TICK_S));
            let wave = |n: f64, angle_per_tick: f64| (n * angle_per_tick).sin();
            let angle = step_m / depth_m;
            let ticks = |angle: f64, turns: f64| (0..(turns * TAU / angle).ceil() as i32).map(f64::from);
            let tap = ticks(angle, 0.5).map(|n| depth_m * wave(n, angle)).chain([-step_m; AFTER_TICKS]);
            let tap = (-LEAD_TICKS..0).map(|n| step_m * f64::from(n)).chain(tap);
            let turn = TAU * SWING_HZ * TICK_S;
            let amplitude_m = (depth_m - mean_m).min(step_m / turn);
            let settled = ramp(mean_m, gentle_m).into_iter().chain([mean_m; AFTER_TICKS]);
            let swing = settled.clone().chain(ticks(turn, 2.0).map(|n| mean_m + amplitude_m * wave(n, turn)));
            let drag_m = step_m.min(DRAG_M_PER_S * TICK_S);
            let drag = settled.map(|depth_m| [depth_m, 0.0]);
            let drag = drag.chain((0..(depth_m / drag_m).ceil() as i32).map(|n| [mean_m, drag_m * f64::from(n)]));
            courses.extend([("tap", straight(tap.collect())), ("swing", straight(swing.collect())), ("drag", drag.collect())]);
        }
        courses
    }
}

/// Largest error over the motions that were tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// Root mean square over the motion, relative to its largest force [%].
    pub rms_pct: f64,
    /// Name of the motion.
    pub motion: &'static str,
}

impl Worst {
    /// The worse of two.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        if other.rms_pct > self.rms_pct { other } else { self }
    }
}

/// Forces of a patch with almost true masses, with which other runs are compared.
#[derive(Clone, Debug)]
pub struct SelfCheck {
    site_m: Vector3<f32>,
    /// Motions, each with its place beside the site [m] and the forces after every tick [N].
    courses: Vec<(Course, [f64; 2], Vec<f64>)>,
}

impl SelfCheck {
    /// Runs a patch with much shorter substeps as the reference, at the site and beside it. `None`
    /// if it does not survive a motion or gives no force.
    ///
    /// # Errors
    /// Fails if the core rejects the model.
    pub fn of(patch: &Patch, params: &Params, approach: Approach) -> Result<Option<Self>, Error> {
        let (site_m, params) = (approach.site_m, with_substeps(params, FINER));
        let mut courses = Vec::new();
        for beside in [[0.0; 2], BESIDE_RADII] {
            let beside_m = beside.map(|radii| radii * f64::from(params.probe.radius_m));
            for course in approach.courses() {
                let Some(force_n) = press(patch, &params, site_m, beside_m, &course.1)? else { return Ok(None) };
                courses.push((course, beside_m, force_n));
            }
        }
        let felt = courses.iter().all(|(_, _, force_n)| force_n.iter().any(|n| *n > 0.0));
        Ok(felt.then_some(Self { site_m, courses }))
    }

    /// Largest error of the same patch with other substeps. `None` if it does not survive a motion.
    ///
    /// # Errors
    /// Fails if the core rejects the model.
    pub fn worst(&self, patch: &Patch, params: &Params) -> Result<Option<Worst>, Error> {
        let mut worst = Worst { rms_pct: 0.0, motion: "" };
        for ((motion, tips), beside_m, true_n) in &self.courses {
            let Some(own_n) = press(patch, params, self.site_m, *beside_m, tips)? else { return Ok(None) };
            let squares: f64 = own_n.iter().zip(true_n).map(|(a, b)| (a - b).powi(2)).sum();
            let largest_n = true_n.iter().copied().fold(0.0, f64::max);
            let rms_pct = (squares / own_n.len() as f64).sqrt() / largest_n * 100.0;
            worst = worst.or(Worst { rms_pct, motion });
        }
        Ok(Some(worst))
    }
}

/// Force along the press after every tick of a motion [N]; `None` if a fault ends it.
fn press(
    patch: &Patch,
    params: &Params,
    site_m: Vector3<f32>,
    beside_m: [f64; 2],
    tips: &[[f64; 2]],
) -> Result<Option<Vec<f64>>, Error> {
    let model = patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, params)?;
    let (axis, site_m) = (params.probe.axis, site_m + params.touch_offset_m());
    let [along, across] = tangents(axis.map(f64::from).into()).map(|t| Vector3::from(t).cast::<f32>());
    let mut force_n = Vec::new();
    for [depth_m, dragged_m] in tips {
        let aside_m = along * (beside_m[0] + dragged_m) as f32 + across * beside_m[1] as f32;
        let out = tick(&model, &tuned, &mut state, ProbePose { tip_m: site_m + aside_m - axis * *depth_m as f32 });
        if out.fault.is_some() {
            return Ok(None);
        }
        force_n.push(f64::from(out.force_n.dot(&axis)));
    }
    // before the touch there is nothing to compare
    Ok(Some(force_n.split_off((LEAD_TICKS as usize + 1).min(force_n.len()))))
}
