//! Hand x delay x device x control: the stiffest wall without a limit cycle, and what holding and leaving 400 N/m costs.
//!
//! Each cell climbs from [`SOFTEST_N_PER_M`] in steps of 12 % until the first wall that is not quiet. Bisecting would be wrong: a loop can shake at
//! one stiffness and hold at a higher one, because friction, the force limit and the encoder's count enter at different ones.
//!
//! An earlier simulation, one axis and written apart, found 139, 952, 2640 and 5836 N/m raw for H0 to H3 one tick late; here it is 155, 1066,
//! 2357 and 2105. H2 and H3 end there by the encoder: the handle swings by a few micrometres across the edge of a count, and that is 50-70 mN. Whether a
//! hold rests on such an edge is luck of the stiffness (H3 is quiet again at 3312 and from 4653 on). With counts of 1 um H3 is quiet to the end
//! and H2 to 3312. Two ticks late H0 ends at 99 against 70: the other pushed with 0.5 N at every stiffness, and so pushed it ends at 79.
//!
//! [`ceiling`] asks what the encoder allows, whatever the control.

pub mod ceiling;
mod report;

pub use report::{pictures, print, write};

use palpate::haptic::cycle::Renderer;
use palpate::path::probe::ProbePose;
use palpate::{BuildError, Limiters, Vector3};
use rayon::prelude::*;
use serde::Serialize;

use self::ceiling::Ceiling;
use crate::closed_loop::control::{CONTROLS, Control};
use crate::closed_loop::device::DeviceProfile;
use crate::closed_loop::hand::{HANDS, Hand};
use crate::closed_loop::run::{Row, Run, Setup, run};
use crate::closed_loop::stimulus::Stimulus;
use crate::closed_loop::surface::Wall;
use crate::closed_loop::verdict::JUDGED;
use crate::error::Error;

/// Where a climb begins [N/m].
pub const SOFTEST_N_PER_M: f64 = 50.0;
/// Its step (1).
pub const STEP: f64 = 1.12;
/// No wall is stiffer [N/m].
pub const STIFFEST_N_PER_M: f64 = 6000.0;
/// What a device of the Touch class must hold [N/m]: its maker's ceiling.
pub const HELD_N_PER_M: f64 = 400.0;
/// Energy that ours may create there [J].
pub const MOST_CREATED_J: f64 = 0.01e-3;
/// Static error that ours may have there (1): rounding and a count that toggles.
pub const MOST_STATIC_ERROR: f64 = 1e-3;
/// Deepest press [m], and share of the force limit that a press may take (1).
const DEPTH_M: f64 = 4e-3;
const FORCE_SHARE: f64 = 0.85;

/// The walls of a climb [N/m].
pub fn walls_n_per_m() -> impl Iterator<Item = f64> {
    std::iter::successors(Some(SOFTEST_N_PER_M), |k| Some(k * STEP)).take_while(|k| *k <= STIFFEST_N_PER_M)
}

/// A loop without its wall.
#[derive(Clone, Copy, Debug)]
pub struct Case<'a> {
    /// The device, with its delay.
    pub device: &'a DeviceProfile,
    /// Who holds it.
    pub hand: Hand,
    /// What keeps it quiet.
    pub control: Control,
}

/// What one wall showed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Trial {
    /// [`holds`].
    pub quiet: bool,
    /// Energy created by the worst contact [mJ].
    pub created_mj: f64,
    /// Force in the last half second over that of the wall at the same readings, less one (1); where it is quiet.
    pub static_error: Option<f64>,
}

/// No limit cycle, no fault, no invariant broken, and not by giving way: the last resort never acted and nothing weakens the force at the end.
#[must_use]
pub fn holds(run: &Run) -> bool {
    let judged_from = run.rows.len().saturating_sub(JUDGED);
    let weakened = |(n, row): (usize, &Row)| {
        row.told.limiters.contains(Limiters::ENERGY) || n >= judged_from && row.told.limiters.contains(Limiters::GAIN)
    };
    run.quiet() && !run.rows.iter().enumerate().any(weakened)
}

impl Case<'_> {
    /// Taps a wall at 0.2 m/s and holds.
    ///
    /// # Errors
    /// A device that the loop refuses.
    pub fn tap(&self, n_per_m: f64) -> Result<Trial, BuildError> {
        let settings = self.control.settings(self.device);
        let limit_n = f64::from(settings.limits.max_force_n);
        let depth_m = DEPTH_M.min(FORCE_SHARE * limit_n / n_per_m);
        let stimulus = Stimulus::tap(0.2);
        let setup = Setup { device: self.device, hand: self.hand, stimulus, settings, depth_m, static_n: n_per_m * depth_m };
        let wall = Wall::new(n_per_m, limit_n, Vector3::z());
        let run = run(&setup, &mut self.control.over(wall, self.device))?;
        let quiet = holds(&run);
        Ok(Trial { quiet, created_mj: run.created_j * 1e3, static_error: quiet.then(|| static_error(&run, wall)) })
    }

    /// The last quiet wall of a climb [N/m]; zero if the softest shakes.
    ///
    /// # Errors
    /// A device that the loop refuses.
    pub fn stiffest_quiet_n_per_m(&self) -> Result<f64, BuildError> {
        let mut stiffest = 0.0;
        for n_per_m in walls_n_per_m() {
            if !self.tap(n_per_m)?.quiet {
                break;
            }
            stiffest = n_per_m;
        }
        Ok(stiffest)
    }
}

/// Of the force against the wall's own at what the loop read, over the ticks that are judged.
fn static_error(run: &Run, mut wall: Wall) -> f64 {
    let judged = run.rows.get(run.rows.len().saturating_sub(JUDGED)..).unwrap_or_default();
    let (mut given_n, mut own_n) = (0.0, 0.0);
    for row in judged {
        let own = wall.render(ProbePose { tip_m: row.told.position_m });
        given_n += f64::from(row.told.applied_n.dot(&own.normal));
        own_n += f64::from(own.force_n.norm());
    }
    if own_n > 0.0 { given_n / own_n - 1.0 } else { 0.0 }
}

/// Stiffest spring [N/m] that any passive hand may hold without the loop giving it energy: `K = b / (T / 2 + t_d)` (Colgate and Schenkel,
/// J. Robotic Systems 14, 1997; with a delay after Gil, Hulin and others), `b` the device's own damping alone.
#[must_use]
pub fn passive_n_per_m(device: &DeviceProfile) -> f64 {
    let late_s = f64::from(device.delay_ticks) * 1e-3 + device.amplifier_lag_s;
    device.damping_n_s_per_m / (0.5e-3 + late_s)
}

/// One cell.
#[derive(Clone, Debug, Serialize)]
pub struct Cell {
    /// Name of the device's profile.
    pub device: String,
    /// Its delay [ticks].
    pub delay_ticks: u8,
    /// H0 .. H6.
    pub hand: &'static str,
    /// What keeps it quiet.
    pub control: String,
    /// Last quiet wall of the climb [N/m].
    pub stiffest_quiet_n_per_m: f64,
    /// Closed form for the device alone [N/m].
    pub passive_n_per_m: f64,
    /// At [`HELD_N_PER_M`].
    pub held: Trial,
}

/// What is measured.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Every device under every control; the shipped ones at delays 0, 1 and 2, then, if asked for, all at their own.
    cases: Vec<(String, DeviceProfile)>,
    ceilings: ceiling::Plan,
}

/// Devices that run at every delay.
const SWEPT: [&str; 2] = ["touch", "frictionless"];

impl Plan {
    /// `quick`: the Touch alone; `full`: every shipped profile too, at its own delay.
    ///
    /// # Errors
    /// A profile that cannot be read.
    pub fn new(quick: bool, full: bool) -> Result<Self, Error> {
        let mut cases = Vec::new();
        for name in if quick { &SWEPT[..1] } else { &SWEPT[..] } {
            let device = DeviceProfile::load(name)?;
            for delay_ticks in 0..=2 {
                cases.push(((*name).to_owned(), DeviceProfile { delay_ticks, ..device.clone() }));
            }
        }
        if full {
            for (name, _) in crate::closed_loop::device::PROFILES.iter().filter(|(name, _)| !SWEPT.contains(name)) {
                cases.push(((*name).to_owned(), DeviceProfile::load(name)?));
            }
        }
        Ok(Self { cases, ceilings: ceiling::Plan::new(quick, full)? })
    }

    /// Steps that [`LoopSummary::measure`] reports one by one.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.cases.len() * HANDS.len() * CONTROLS.len() + self.ceilings.steps()
    }
}

/// Everything measured.
#[derive(Clone, Debug, Serialize)]
pub struct LoopSummary {
    /// Step of a climb (1), its end [N/m].
    pub step: f64,
    /// [N/m]
    pub stiffest_tried_n_per_m: f64,
    /// Every cell.
    pub cells: Vec<Cell>,
    /// What the encoders allow.
    pub ceilings: Vec<Ceiling>,
    /// What was promised and did not hold.
    pub broken: Vec<String>,
}

impl LoopSummary {
    /// Measures; `done` is told after every step.
    ///
    /// # Errors
    /// A device or a patch that the loop refuses.
    pub fn measure(plan: &Plan, done: &(impl Fn() + Sync)) -> Result<Self, Error> {
        let cases: Vec<_> = plan
            .cases
            .iter()
            .flat_map(|(name, device)| CONTROLS.iter().flat_map(move |c| HANDS.map(|hand| (name, device, hand, *c))))
            .collect();
        let measure = |(name, device, hand, control): &(&String, &DeviceProfile, Hand, Control)| {
            let case = Case { device, hand: *hand, control: *control };
            let cell = Cell {
                device: (*name).clone(),
                delay_ticks: device.delay_ticks,
                hand: hand.id,
                control: control.name(),
                stiffest_quiet_n_per_m: case.stiffest_quiet_n_per_m()?,
                passive_n_per_m: passive_n_per_m(device),
                held: case.tap(HELD_N_PER_M)?,
            };
            done();
            Ok(cell)
        };
        let cells: Vec<Cell> = cases.par_iter().map(measure).collect::<Result<_, BuildError>>()?;
        let ceilings = plan.ceilings.measure(done)?;
        let broken = broken(&cells);
        let stiffest_tried_n_per_m = walls_n_per_m().last().unwrap_or(SOFTEST_N_PER_M);
        Ok(Self { step: STEP, stiffest_tried_n_per_m, cells, ceilings, broken })
    }

    /// The promise.
    ///
    /// # Errors
    /// What of it did not hold.
    pub fn check(&self) -> Result<(), Error> {
        if self.broken.is_empty() { Ok(()) } else { Err(Error::Check(self.broken.join("; "))) }
    }

    /// Cells of a device, a delay and a control, one a hand.
    fn row<'a>(&'a self, device: &'a str, delay_ticks: u8, control: &'a str) -> impl Iterator<Item = &'a Cell> {
        self.cells.iter().filter(move |c| c.device == device && c.delay_ticks == delay_ticks && c.control == control)
    }
}

/// Ours holds [`HELD_N_PER_M`] without energy and without static error, in every hand: on the Touch up to two ticks late, without friction up
/// to one.
fn broken(cells: &[Cell]) -> Vec<String> {
    let promised =
        |c: &&Cell| c.control == Control::Ours.name() && (c.device == SWEPT[0] || c.device == SWEPT[1] && c.delay_ticks <= 1);
    let mut broken = Vec::new();
    for cell in cells.iter().filter(promised) {
        let place = format!("{}, {} ticks late, {}, {HELD_N_PER_M} N/m", cell.device, cell.delay_ticks, cell.hand);
        let held = &cell.held;
        if !held.quiet || cell.stiffest_quiet_n_per_m * STEP < HELD_N_PER_M {
            broken.push(format!("{place}: quiet only up to {:.0} N/m", cell.stiffest_quiet_n_per_m));
        }
        if held.created_mj > MOST_CREATED_J * 1e3 {
            broken.push(format!("{place}: {:.3} mJ created", held.created_mj));
        }
        if let Some(error) = held.static_error.filter(|e| e.abs() > MOST_STATIC_ERROR) {
            broken.push(format!("{place}: static error {:.2} %", error * 100.0));
        }
    }
    broken
}
