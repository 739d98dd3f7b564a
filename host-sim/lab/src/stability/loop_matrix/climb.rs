//! A climb: one loop against walls of rising stiffness.

use palpate::haptic::account::AccountSettings;
use palpate::haptic::cycle::{Renderer, Settings};
use palpate::stages::probe::ProbePose;
use palpate::{BuildError, ClampFlags, Vector3};
use serde::{Deserialize, Serialize};

use super::{DEPTH_M, FORCE_SHARE, SOFTEST_N_PER_M, STEP, STIFFEST_N_PER_M};
use crate::stability::controller::Controller;
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::Hand;
use palpate_loop::closed_loop::run::{Row, Run, Setup, run};
use palpate_loop::closed_loop::stimulus::Stimulus;
use palpate_loop::closed_loop::surface::Wall;
use palpate_loop::closed_loop::verdict::JUDGED;

/// Stiffnesses of the walls of a climb [N/m].
pub fn walls_n_per_m() -> impl Iterator<Item = f64> {
    std::iter::successors(Some(SOFTEST_N_PER_M), |k| Some(k * STEP)).take_while(|k| *k <= STIFFEST_N_PER_M)
}

/// A loop without its wall.
#[derive(Clone, Copy, Debug)]
pub struct LoopSetup<'a> {
    /// Device with its delay.
    pub device: &'a DeviceProfile,
    /// Hand that holds the device.
    pub hand: Hand,
    /// Controller of the loop.
    pub control: Controller,
}

/// Result of a tap on one wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TapResult {
    /// Whether the run was quiet, as [`quiet`] defines it.
    pub quiet: bool,
    /// Whether the loop renders a weaker wall than requested, because the hand overshot into the
    /// force limit for too long. This is not a limit cycle.
    pub weakened: bool,
    /// Largest energy that a contact created [mJ].
    pub created_mj: f64,
    /// Relative deviation of the force in the last half second from that of the wall at the same
    /// readings (1); `None` if the run was not quiet or the wall was weakened.
    pub static_error: Option<f64>,
}

impl TapResult {
    /// Whether the run was quiet with the requested wall.
    pub fn holds(&self) -> bool {
        self.quiet && !self.weakened
    }
}

/// Energy that a contact may create in a run that counts as quiet [J].
const MOST_CREATED_J: f64 = 0.1e-3;

/// Whether a run has no limit cycle, no fault and no broken invariant, and, under an account that
/// can run out, no contact that created energy that a hand could feel. Without such an account the
/// port may give energy and shake for a while, as long as it comes to rest. The account may act on
/// a leaving probe, since that does not change the stiffness at rest.
pub fn quiet(run: &Run, settings: &Settings) -> bool {
    if settings.account != AccountSettings::HIGHEST {
        return run.quiet() && run.created_j <= MOST_CREATED_J;
    }
    let unbroken = run.broken.iter().all(|broken| matches!(broken.id, "I11" | "I15"));
    unbroken && run.fault.is_none() && !run.hold.is_some_and(|hold| hold.limit_cycle())
}

/// Whether the loop renders a weaker wall than requested at the end of a run.
pub(super) fn weakened(run: &Run) -> bool {
    judged(run)
        .iter()
        .any(|row| row.telemetry.limiters.contains(ClampFlags::GAIN) || row.telemetry.limiters.contains(ClampFlags::ENERGY))
}

fn judged(run: &Run) -> &[Row] {
    run.rows.get(run.rows.len().saturating_sub(JUDGED)..).unwrap_or_default()
}

/// Result of a climb.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Climb {
    /// Stiffest wall that was held as requested [N/m]; zero if none was.
    pub n_per_m: f64,
    /// Whether no wall of the climb was unstable, so that it ended at [`STIFFEST_N_PER_M`]. A wall
    /// at which the loop reduced its gain is skipped.
    pub at_least: bool,
}

impl LoopSetup<'_> {
    /// Taps a wall at 0.2 m/s and holds the contact.
    pub fn tap(&self, n_per_m: f64) -> Result<TapResult, BuildError> {
        let settings = self.control.settings(self.device);
        let limit_n = f64::from(settings.limits.max_force_n);
        let depth_m = DEPTH_M.min(FORCE_SHARE * limit_n / n_per_m);
        let stimulus = Stimulus::tap(0.2);
        let setup = Setup { device: self.device, hand: self.hand, stimulus, settings, depth_m, static_n: n_per_m * depth_m };
        let wall = Wall::new(n_per_m, limit_n, Vector3::z());
        let run = run(&setup, &mut self.control.over(wall, self.device))?;
        let mut trial = TapResult {
            quiet: quiet(&run, &setup.settings),
            weakened: weakened(&run),
            created_mj: run.created_j * 1e3,
            static_error: None,
        };
        trial.static_error = trial.holds().then(|| static_error(&run, wall));
        Ok(trial)
    }

    /// Climbs until the loop shakes on a wall.
    pub fn climb(&self) -> Result<Climb, BuildError> {
        let mut stiffest = 0.0;
        for n_per_m in walls_n_per_m() {
            let trial = self.tap(n_per_m)?;
            if !trial.quiet {
                return Ok(Climb { n_per_m: stiffest, at_least: false });
            }
            if trial.holds() {
                stiffest = n_per_m;
            }
        }
        Ok(Climb { n_per_m: stiffest, at_least: true })
    }
}

/// Relative deviation of the mean force from that of the wall at the loop's readings, over the
/// evaluated ticks (1).
fn static_error(run: &Run, mut wall: Wall) -> f64 {
    let (mut given_n, mut own_n) = (0.0, 0.0);
    for row in judged(run) {
        let own = wall.render(ProbePose { tip_m: row.telemetry.position_m });
        given_n += f64::from(row.telemetry.applied_n.dot(&own.normal));
        own_n += f64::from(own.force_n.norm());
    }
    if own_n > 0.0 { given_n / own_n - 1.0 } else { 0.0 }
}
