//! Forces of a patch as it runs: ticks of the core press it, through guard, presence and
//! foundation, and hold it at each depth until the force is at rest.
//!
//! The static solver of a fit knows neither the guard nor a patch that springs cannot hold; a force
//! that is stated to a user therefore comes from here.

use palpate::{ClampFlags, Params, ProbePose, State, Terms, Vector3, tick};

use crate::statics::Vector;
use palpate_tissue::error::Error;
use palpate_tissue::patch::Memory;
use palpate_tissue::scene::TICK_S;
use palpate_tissue::session::Session;

/// Speed of the press [m/s], that of a hand that palpates slowly.
const SPEED_M_PER_S: f64 = 0.04;
/// Damping of the nodes [1/s], close to critical for the slowest motion: the force at rest does not
/// depend on it, and is reached in a third of the ticks.
const DAMPING_PER_S: f32 = 100.0;
/// Largest deviation of the force from its mean over one window, as a share of the mean, at which
/// it counts as at rest (1).
const RESTS: f64 = 3e-4;
const WINDOW_TICKS: usize = 25;
/// Number of ticks of a hold after which the press counts as lost.
const HOLD_TICKS: usize = 4_000;

/// A patch that is pressed by ticks of the core.
pub struct SettledPatch<'a> {
    session: &'a Session,
    params: Params,
}

/// A press that was held until the force came to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settled {
    /// Force along the press over Young's modulus [m^2].
    pub force_m2: f64,
    /// Whether the depth limit of the patch acted.
    pub limited: bool,
}

impl<'a> SettledPatch<'a> {
    /// Takes the patch of a session, without friction and relaxation, which no static reference
    /// has.
    #[must_use]
    pub fn of(session: &'a Session) -> Self {
        let Params { terms, node_damping_per_s, .. } = session.params;
        let terms = Terms { friction: false, relaxation: false, ..terms };
        let node_damping_per_s = node_damping_per_s.max(DAMPING_PER_S);
        Self { session, params: Params { terms, node_damping_per_s, ..session.params } }
    }

    /// Presses at an offset from the site [m] to ascending depths [m]. `None` stands for a press
    /// that faults, that the speed or the force limit disturbs, or that does not come to rest, and
    /// for all deeper ones.
    ///
    /// # Errors
    /// Fails if the core rejects the model.
    pub fn press(&self, offset_m: Vector, depths_m: &[f64]) -> Result<Vec<Option<Settled>>, Error> {
        self.press_seen(offset_m, depths_m, |_, _, _| ())
    }

    /// Presses as [`Self::press`] does; `see` is called at the end of each hold with the number of
    /// its depth, the tip [m] and the state.
    ///
    /// # Errors
    /// Fails if the core rejects the model.
    pub fn press_seen(
        &self,
        offset_m: Vector,
        depths_m: &[f64],
        mut see: impl FnMut(usize, Vector3<f32>, &State),
    ) -> Result<Vec<Option<Settled>>, Error> {
        let model = self.session.patch.wide_model();
        let mut memory = Memory::for_model(&model);
        let (tuned, mut state) = memory.start(&model, &self.params)?;
        let axis: Vector = self.params.probe.axis.cast();
        let place_m = self.session.touch_m().cast() + offset_m;
        let tip_m = |depth_m: f64| (place_m - axis * depth_m).cast();
        // on a curved surface, the rim of a flat tip touches before its middle does
        let step_m = SPEED_M_PER_S * TICK_S;
        let mut at_m = -f64::from(self.params.probe.radius_m);
        let pressed = |depth_m: f64, state: &mut State| {
            let output = tick(&model, &tuned, state, ProbePose { tip_m: tip_m(depth_m) });
            let clamped = |flag| output.limiters.contains(flag);
            // beyond the depth limit, the shown tip lags behind for another reason than its speed
            let limited = clamped(ClampFlags::DEPTH);
            let disturbed = clamped(ClampFlags::FORCE) || clamped(ClampFlags::BURIED) || clamped(ClampFlags::SPEED) && !limited;
            (output.fault.is_none() && !disturbed).then(|| (output.force_n.cast::<f64>().dot(&axis), limited))
        };
        let mut hold = |depth_m: f64, state: &mut State| {
            while at_m < depth_m {
                pressed(at_m, state)?;
                at_m += step_m;
            }
            at_m = depth_m;
            let mut window = [0.0; WINDOW_TICKS];
            let mut limited = false;
            for _ in 0..HOLD_TICKS / WINDOW_TICKS {
                for force_n in &mut window {
                    (*force_n, limited) = pressed(depth_m, state)?;
                }
                let mean_n = window.iter().sum::<f64>() / WINDOW_TICKS as f64;
                if mean_n > 0.0 && window.iter().all(|force_n| (force_n / mean_n - 1.0).abs() < RESTS) {
                    return Some(Settled { force_m2: mean_n / f64::from(self.params.youngs_modulus_pa), limited });
                }
            }
            None
        };
        let mut found = vec![None; depths_m.len()];
        for (n, (depth_m, found)) in depths_m.iter().zip(&mut found).enumerate() {
            *found = hold(*depth_m, &mut state);
            if found.is_none() {
                break;
            }
            see(n, tip_m(*depth_m), &state);
        }
        Ok(found)
    }
}
