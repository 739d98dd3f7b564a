//! Forces of a patch, including places where the static solver finds no equilibrium.
//!
//! Under the edge of a flat tip, and where springs can buckle into two shapes, Newton's iteration
//! may not converge although the running patch settles. A verdict without such places would be too
//! favourable; therefore ticks of the core press the patch there and hold it until the force is at
//! rest.

use std::sync::OnceLock;

use palpate::{ClampFlags, Params, ProbePose, Terms, tick};

use crate::pressed_patch::PressedPatch;
use crate::statics::{Unbalanced, Vector};
use palpate_tissue::budget::MACHINES;
use palpate_tissue::patch::{Memory, Patch};
use palpate_tissue::scene::TICK_S;
use palpate_tissue::session::Session;

/// Speed of the press [m/s], slow compared with the waves in the softest tissue.
const SPEED_M_PER_S: f64 = 0.02;
/// Largest deviation of the force from its mean over one window, as a share of the mean, at which
/// it counts as at rest (1).
const RESTS: f64 = 1e-3;
const WINDOW_TICKS: usize = 100;
/// Number of ticks of a hold after which the press counts as lost.
const HOLD_TICKS: usize = 4_000;

/// A patch that is pressed in static equilibrium, and by ticks of the core where there is no
/// equilibrium.
pub struct SettledPatch<'a> {
    /// Patch in static equilibrium.
    pub balanced: PressedPatch,
    patch: &'a Patch,
    params: Params,
    /// The running patch, which is built at the first press without equilibrium; `None` if it
    /// cannot run.
    running: OnceLock<Option<Session>>,
}

/// Force of one press over Young's modulus [m^2].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PressForce {
    /// Force in static equilibrium.
    Balanced(f64),
    /// Force of the running patch after it came to rest.
    Settled(f64),
    /// Neither a static equilibrium nor a state of rest was found.
    Lost,
}

impl PressForce {
    /// The force over Young's modulus, if it was found [m^2].
    #[must_use]
    pub fn found_m2(self) -> Option<f64> {
        match self {
            Self::Balanced(force_m2) | Self::Settled(force_m2) => Some(force_m2),
            Self::Lost => None,
        }
    }
}

impl<'a> SettledPatch<'a> {
    /// Brings a patch to rest under a probe that does not touch it yet.
    ///
    /// # Errors
    /// Fails if the patch has no equilibrium at rest.
    pub fn of(patch: &'a Patch, params: &Params) -> Result<Self, Unbalanced> {
        let balanced = PressedPatch::of(patch, params)?;
        Ok(Self { balanced, patch, params: *params, running: OnceLock::new() })
    }

    /// Force of each press at an offset from the site [m] to ascending depths [m].
    #[must_use]
    pub fn press(&self, offset_m: Vector, depths_m: &[f64]) -> Vec<PressForce> {
        let (found, _) = self.balanced.press_while_balanced(offset_m, depths_m.iter().copied(), |_, here| here.force);
        let lost = depths_m.iter().skip(found.len());
        let settled = lost
            .map(|depth_m| self.settled_m2(offset_m, *depth_m).map_or(PressForce::Lost, PressForce::Settled))
            .collect::<Vec<_>>();
        found.into_iter().map(PressForce::Balanced).chain(settled).collect()
    }

    /// Force over Young's modulus [m^2] of the running patch after it was pressed to a depth [m]
    /// and held until the force is at rest; `None` if it faults or does not come to rest.
    #[must_use]
    pub fn settled_m2(&self, offset_m: Vector, depth_m: f64) -> Option<f64> {
        // static equilibrium does not include friction and relaxation
        let terms = Terms { friction: false, relaxation: false, ..self.params.terms };
        let params = Params { terms, ..self.params };
        let running = self.running.get_or_init(|| Session::of_fitted(&MACHINES[0], self.patch.clone(), params).ok());
        let session = running.as_ref()?;
        let model = session.patch.wide_model();
        let mut memory = Memory::for_model(&model);
        let (tuned, mut state) = memory.start(&model, &session.params).ok()?;
        let (place_m, axis) = (self.balanced.site_m + offset_m, self.balanced.statics.axis());
        // a force that a limiter has clamped is not that of the tissue
        let mut pressed = |depth_m: f64| {
            let pose = ProbePose { tip_m: (place_m - axis * depth_m).cast() };
            let output = tick(&model, &tuned, &mut state, pose);
            let free = output.fault.is_none() && output.limiters == ClampFlags::default();
            free.then(|| output.force_n.cast::<f64>().dot(&axis))
        };
        // on a curved surface, the rim of a flat tip touches before its middle does
        let (step_m, clear_m) = (SPEED_M_PER_S * TICK_S, f64::from(session.params.probe.radius_m));
        let ramp_ticks = ((depth_m + clear_m) / step_m).floor() as i32;
        for n in 0..=ramp_ticks {
            pressed(f64::from(n) * step_m - clear_m)?;
        }
        let mut window = Vec::with_capacity(WINDOW_TICKS);
        for _ in 0..HOLD_TICKS / WINDOW_TICKS {
            window.clear();
            for _ in 0..WINDOW_TICKS {
                window.push(pressed(depth_m)?);
            }
            let mean_n = window.iter().sum::<f64>() / WINDOW_TICKS as f64;
            if mean_n > 0.0 && window.iter().all(|force_n| (force_n / mean_n - 1.0).abs() < RESTS) {
                return Some(mean_n / f64::from(session.params.youngs_modulus_pa));
            }
        }
        None
    }
}
