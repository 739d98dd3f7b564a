//! Ceiling that the encoder resolution sets for every controller: the stiffest contact in which one
//! count is not felt.
//!
//! A count that toggles changes the force by stiffness times count. The handle does not move while
//! that change is less than the friction can hold, `2 f_c` (Abbott and Okamura, IEEE Trans.
//! Robotics 21, 2005: `K <= 2 f_c / count`), and a hand does not notice a variation of less than 20
//! mN to either side. The ceiling is compared with the slope of the force-depth curve of tissues,
//! and with the behaviour of the loop: the stiffest tissue that is held quietly.

use std::ops::Range;

use palpate::Params;
use rayon::prelude::*;
use serde::{Deserialize, Deserializer, Serialize};

use super::climb::{quiet, weakened};
use super::{DEPTH_M, FORCE_SHARE};
use crate::error::Error;
use crate::stability::controller::Controller;
use palpate_loop::closed_loop::device::{DeviceProfile, PROFILES};
use palpate_loop::closed_loop::fidelity;
use palpate_loop::closed_loop::hand::{self, HANDS, Hand};
use palpate_loop::closed_loop::run::{Setup, run};
use palpate_loop::closed_loop::stimulus::Stimulus;
use palpate_loop::closed_loop::surface::{depth_at_m, force_at_n, static_curve, with_tissue};
use palpate_loop::closed_loop::verdict::FELT_N;
use palpate_tissue::Error as TissueError;
use palpate_tissue::patch::Patch;
use palpate_tissue::session::calibrated;
use palpate_tissue::stable_step::limits;

/// Number of nodes of the calibrated block that is pressed.
const NODES: usize = 130;
/// Depth limit of that block [m].
const DEEP_M: f32 = 8e-3;
/// Young's moduli of the tissues whose slope is tabulated [Pa].
pub const TABLED_PA: [f64; 3] = [3.5e3, 20e3, 100e3];
/// Depths at which the slope is tabulated [m].
pub const TABLED_M: [f64; 4] = [1e-3, 2e-3, 3e-3, 4e-3];
/// Range of Young's moduli that are tried [Pa], and the factor from one to the next (1).
const SOFTEST_PA: f64 = 3.5e3;
const STIFFEST_PA: f64 = 200e3;
const STEP: f64 = 1.25;
/// Indices of the hands that hold a device, H1 to H3.
const HOLDING: std::ops::Range<usize> = 1..4;

/// Contact stiffness of a tissue under the probe.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slope {
    /// Young's modulus of the tissue [Pa].
    pub youngs_modulus_pa: f64,
    /// Depth of the tip [m].
    pub depth_m: f64,
    /// Force at that depth [N].
    pub force_n: f64,
    /// Slope of the force over the depth at that point [N/m].
    pub n_per_m: f64,
}

/// Ceiling of a device.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Ceiling {
    /// Name of the device's profile.
    pub device: String,
    /// Displacement of the tip per encoder count [m].
    pub count_m: f64,
    /// Coulomb friction [N].
    pub friction_n: f64,
    /// Largest force that the loop outputs [N].
    pub limit_n: f64,
    /// Contact stiffness above which one count is felt [N/m].
    pub felt_n_per_m: f64,
    /// Slopes of the tabulated tissues up to 0.85 of the force limit.
    pub slopes: Vec<Slope>,
    /// Young's modulus of the stiffest tissue that each hand held quietly [Pa]; zero if it held
    /// none.
    #[serde(deserialize_with = "held")]
    pub held_pa: Vec<(hand::Id, f64)>,
}

fn held<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<(hand::Id, f64)>, D::Error> {
    #[derive(Deserialize)]
    struct Held(#[serde(deserialize_with = "hand::id")] hand::Id, f64);
    Ok(Vec::<Held>::deserialize(from)?.into_iter().map(|Held(hand, pa)| (hand, pa)).collect())
}

/// Combines ceilings of one hand each, which are in the order of devices and hands, into ceilings
/// of all hands.
pub(super) fn joined(parts: Vec<Ceiling>) -> Vec<Ceiling> {
    let mut joined: Vec<Ceiling> = Vec::new();
    for part in parts {
        match joined.last_mut().filter(|last| last.device == part.device) {
            Some(last) => last.held_pa.extend(part.held_pa),
            None => joined.push(part),
        }
    }
    joined
}

/// Contact stiffness above which one count is felt [N/m].
pub fn felt_n_per_m(device: &DeviceProfile) -> f64 {
    (2.0 * device.friction_n).max(2.0 * FELT_N) / device.count_m
}

/// Scope of the measurement: devices, and tissues of the climb.
#[derive(Clone, Debug)]
pub(super) struct Scope {
    devices: Vec<(&'static str, DeviceProfile)>,
    climb_pa: Vec<f64>,
}

/// A prepared tissue: patch, parameters with the substeps that its taps need, and static
/// force-depth curve.
#[derive(Debug)]
struct Ready {
    youngs_modulus_pa: f64,
    patch: Patch,
    params: Params,
    curve: Vec<(f64, f64)>,
}

impl Scope {
    /// `quick` takes only the Touch, on every other tissue of the climb.
    pub(super) fn new(quick: bool, full: bool) -> Result<Self, Error> {
        let swept = if quick { &super::SWEPT[..1] } else { &super::SWEPT[..] };
        let names = PROFILES.iter().map(|p| p.0).filter(|name| full || swept.contains(name));
        let devices = names.map(|name| Ok((name, DeviceProfile::load(name)?))).collect::<Result<_, Error>>()?;
        let step = if quick { STEP * STEP } else { STEP };
        let climb_pa = std::iter::successors(Some(SOFTEST_PA), |e| Some(e * step)).take_while(|e| *e <= STIFFEST_PA).collect();
        Ok(Self { devices, climb_pa })
    }

    /// Number of devices times number of hands that hold them.
    pub(super) fn cases(&self) -> usize {
        self.devices.len() * HOLDING.len()
    }

    pub(super) fn steps(&self, cases: Range<usize>) -> usize {
        // the tissues are prepared once for all cases
        let tissues = if cases.is_empty() { 0 } else { self.climb_pa.len() + TABLED_PA.len() };
        tissues + cases.len()
    }

    pub(super) fn measure(&self, cases: Range<usize>, done: &(impl Fn() + Sync)) -> Result<Vec<Ceiling>, Error> {
        if cases.is_empty() {
            return Ok(Vec::new());
        }
        let tissues: Vec<f64> = self.climb_pa.iter().chain(&TABLED_PA).copied().collect();
        let ready: Vec<Ready> = tissues
            .par_iter()
            .map(|e| {
                let ready = Ready::new(*e);
                done();
                ready
            })
            .collect::<Result<_, Error>>()?;
        let (climb, tabled) = ready.split_at(self.climb_pa.len());
        let pairs = self.devices.iter().flat_map(|(name, device)| HANDS[HOLDING].iter().map(move |h| (*name, device, *h)));
        let pairs: Vec<(&str, &DeviceProfile, Hand)> = pairs.take(cases.end).skip(cases.start).collect();
        let ceiling = |(name, device, hand): &(&str, &DeviceProfile, Hand)| {
            let held_pa = stiffest_held_pa(climb, device, *hand);
            done();
            Ok(Ceiling {
                device: (*name).to_owned(),
                count_m: device.count_m,
                friction_n: device.friction_n,
                limit_n: limit_n(device),
                felt_n_per_m: felt_n_per_m(device),
                slopes: slopes(tabled, device),
                held_pa: vec![(hand.id, held_pa?)],
            })
        };
        pairs.par_iter().map(ceiling).collect()
    }
}

fn limit_n(device: &DeviceProfile) -> f64 {
    f64::from(Controller::Ours.settings(device).limits.max_force_n)
}

impl Ready {
    fn new(youngs_modulus_pa: f64) -> Result<Self, Error> {
        let Some((mut patch, packed)) = calibrated::sized(NODES) else {
            return Err(TissueError::Usage(format!("the patch of {NODES} nodes that ships cannot be read: build again")).into());
        };
        let limits = limits(&patch, f64::from(packed.tick_s));
        patch.set_depth_limit_m(DEEP_M);
        let one_step = Params { limits, substeps: 1, youngs_modulus_pa: youngs_modulus_pa as f32, ..packed };
        let params = fidelity::derive(&patch, &one_step, DEPTH_M)?.params;
        let curve = static_curve(&patch, &params)?;
        Ok(Self { youngs_modulus_pa, patch, params, curve })
    }

    fn depth_m(&self, device: &DeviceProfile) -> f64 {
        DEPTH_M.min(depth_at_m(&self.curve, FORCE_SHARE * limit_n(device)))
    }
}

fn stiffest_held_pa(climb: &[Ready], device: &DeviceProfile, hand: Hand) -> Result<f64, Error> {
    let mut stiffest_pa = 0.0;
    for tissue in climb {
        let depth_m = tissue.depth_m(device);
        let static_n = force_at_n(&tissue.curve, depth_m);
        let settings = Controller::Ours.settings(device);
        let setup = Setup { device, hand, stimulus: Stimulus::tap(0.05), settings, depth_m, static_n };
        let held = with_tissue(&tissue.patch, &tissue.params, |surface| run(&setup, surface))??;
        if !quiet(&held, &setup.settings) || weakened(&held) {
            break;
        }
        stiffest_pa = tissue.youngs_modulus_pa;
    }
    Ok(stiffest_pa)
}

fn slopes(tabled: &[Ready], device: &DeviceProfile) -> Vec<Slope> {
    let half_m = 0.25e-3;
    let mut slopes = Vec::new();
    for tissue in tabled {
        let deepest_m = tissue.depth_m(device);
        let tabled = TABLED_M.into_iter().filter(|d| *d < deepest_m * 0.999);
        for depth_m in tabled.chain([deepest_m]) {
            let at = |depth_m: f64| force_at_n(&tissue.curve, depth_m);
            let n_per_m = (at(depth_m + half_m) - at(depth_m - half_m)) / (2.0 * half_m);
            slopes.push(Slope { youngs_modulus_pa: tissue.youngs_modulus_pa, depth_m, force_n: at(depth_m), n_per_m });
        }
    }
    slopes
}
