//! One loop against one wall after the other, softest first.

use palpate::haptic::cycle::{Renderer, Settings};
use palpate::stages::probe::ProbePose;
use palpate::{BuildError, ClampFlags, Vector3};
use serde::{Deserialize, Serialize};

use super::{DEPTH_M, FORCE_SHARE, SOFTEST_N_PER_M, STEP, STIFFEST_N_PER_M};
use palpate_loop::closed_loop::controller::Controller;
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::Hand;
use palpate_loop::closed_loop::run::{Row, Run, Setup, run};
use palpate_loop::closed_loop::stimulus::Stimulus;
use palpate_loop::closed_loop::surface::Wall;
use palpate_loop::closed_loop::verdict::JUDGED;

/// The walls of a climb [N/m].
pub fn walls_n_per_m() -> impl Iterator<Item = f64> {
    std::iter::successors(Some(SOFTEST_N_PER_M), |k| Some(k * STEP)).take_while(|k| *k <= STIFFEST_N_PER_M)
}

/// A loop without its wall.
#[derive(Clone, Copy, Debug)]
pub struct LoopSetup<'a> {
    /// The device, with its delay.
    pub device: &'a DeviceProfile,
    /// Hand that holds the device.
    pub hand: Hand,
    /// Controller that keeps the loop quiet.
    pub control: Controller,
}

/// Result of a tap on one wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TapResult {
    /// [`quiet`].
    pub quiet: bool,
    /// The hand overshot into the force limit for so long that the loop renders a weaker wall:
    /// neither a limit cycle nor the requested wall.
    pub weakened: bool,
    /// Energy created by the worst contact [mJ].
    pub created_mj: f64,
    /// Force in the last half second over that of the wall at the same readings, less one (1);
    /// where it is quiet and whole.
    pub static_error: Option<f64>,
}

impl TapResult {
    /// Quiet, with the requested wall.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.quiet && !self.weakened
    }
}

/// Whether a run has no limit cycle, no fault, no broken invariant and no weakening: no contact
/// created the energy of the alarm. The bound on the work of a leaving probe may act: it leaves the
/// stiffness at rest as it is.
#[must_use]
pub fn quiet(run: &Run, settings: &Settings) -> bool {
    run.quiet() && !run.rows.iter().any(|row| row.telemetry.energy.created_j > settings.passivity.alarm_j)
}

/// The force at the end is weaker than the requested one.
pub(super) fn weakened(run: &Run) -> bool {
    judged(run).iter().any(|row| row.telemetry.limiters.contains(ClampFlags::GAIN))
}

fn judged(run: &Run) -> &[Row] {
    run.rows.get(run.rows.len().saturating_sub(JUDGED)..).unwrap_or_default()
}

/// Result of a climb.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Climb {
    /// Stiffest wall that was stable [N/m]; zero if the softest is unstable.
    pub n_per_m: f64,
    /// No stiffness of the climb was unstable: the climb ended at [`STIFFEST_N_PER_M`], or at the
    /// first stiffness whose force exceeds the force limit.
    pub at_least: bool,
}

impl LoopSetup<'_> {
    /// Taps a wall at 0.2 m/s and holds.
    ///
    /// # Errors
    /// A device that the loop refuses.
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

    /// Climbs until a wall shakes.
    ///
    /// # Errors
    /// A device that the loop refuses.
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

/// Mean ratio of the force to the wall's own at the loop's readings, over the evaluated ticks.
fn static_error(run: &Run, mut wall: Wall) -> f64 {
    let (mut given_n, mut own_n) = (0.0, 0.0);
    for row in judged(run) {
        let own = wall.render(ProbePose { tip_m: row.telemetry.position_m });
        given_n += f64::from(row.telemetry.applied_n.dot(&own.normal));
        own_n += f64::from(own.force_n.norm());
    }
    if own_n > 0.0 { given_n / own_n - 1.0 } else { 0.0 }
}
