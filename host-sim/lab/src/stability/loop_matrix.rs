//! Matrix of hand, delay, device and control: the stiffest wall without a limit cycle, and the
//! energy and the error when a wall of 400 N/m is held and left.
//!
//! In each cell the stiffness climbs from [`SOFTEST_N_PER_M`] in steps of 12 % until the first wall
//! that is not quiet. Bisection would be wrong: a loop can shake at one stiffness and be quiet at a
//! higher one, because friction, the force limit and the encoder resolution take effect at
//! different stiffnesses.
//!
//! An earlier, independent simulation with one axis found limits of 139, 952, 2640 and 5836 N/m for
//! the raw controller with H0 to H3 at a delay of one tick; here they are 155, 1066, 2357 and 2105
//! N/m. H2 and H3 end there because of the encoder: the handle moves by a few micrometres across
//! the boundary of a count, which changes the force by 50-70 mN. It is a matter of chance at which
//! stiffnesses a hold comes to rest on such a boundary (H3 is quiet again at 3312 N/m and from 4653
//! N/m on). With counts of 1 um H3 is quiet to the end of the climb and H2 up to 3312 N/m. At a
//! delay of two ticks H0 ends at 99 N/m here and at 70 N/m there: the other simulation pushed with
//! 0.5 N at every stiffness, and with that push ours ends at 79 N/m.
//!
//! [`ceiling`] gives the limit that the encoder sets for every controller.

pub mod ceiling;
mod climb;
mod report;

pub use climb::{Climb, LoopSetup, TapResult, quiet, walls_n_per_m};
pub use report::report;

use std::ops::Range;

use palpate::BuildError;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::ceiling::Ceiling;
use crate::error::Error;
use crate::stability::controller::{CONTROLLERS, Controller};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::{self, HANDS, Hand};

/// First stiffness of a climb [N/m].
pub const SOFTEST_N_PER_M: f64 = 50.0;
/// Factor from one stiffness of a climb to the next (1).
pub const STEP: f64 = 1.12;
/// Largest stiffness of a climb [N/m].
pub const STIFFEST_N_PER_M: f64 = 6000.0;
/// Stiffness that a device of the Touch class must hold [N/m]: the maximum that its maker states.
pub const HELD_N_PER_M: f64 = 400.0;
/// Largest energy that our controller may create on such a wall [J].
pub const MOST_CREATED_J: f64 = 0.01e-3;
/// Largest static error that our controller may have on such a wall (1), which allows for rounding
/// and for one toggling count.
pub const MOST_STATIC_ERROR: f64 = 1e-3;
/// Largest depth of a press [m], and share of the force limit that a press may reach (1).
const DEPTH_M: f64 = 4e-3;
const FORCE_SHARE: f64 = 0.85;

/// Largest stiffness of a spring [N/m] that any passive hand can hold without the loop creating
/// energy: `K = (b - |B|) / (T / 2 + t_d)` (Colgate and Schenkel, J. Robotic Systems 14, 1997; with
/// a delay after Gil, Hulin and others), `b` the device's own damping and `B = 0`, the wall's.
pub fn passive_n_per_m(device: &DeviceProfile) -> f64 {
    let late_s = f64::from(device.delay_ticks) * 1e-3 + device.amplifier_lag_s;
    device.damping_n_s_per_m / (0.5e-3 + late_s)
}

/// One cell of the matrix.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Cell {
    /// Name of the device's profile.
    pub device: String,
    /// Delay of the device [ticks].
    pub delay_ticks: u8,
    /// Hand, H0 .. H6.
    #[serde(deserialize_with = "hand::id")]
    pub hand: hand::Id,
    /// Name of the controller.
    pub control: String,
    /// Result of the climb.
    pub climb: Climb,
    /// Closed form [`passive_n_per_m`] for the device [N/m].
    pub passive_n_per_m: f64,
    /// Result of a tap on a wall of [`HELD_N_PER_M`].
    pub held: TapResult,
}

/// Scope of the measurements: cells of the matrix and encoder ceilings.
#[derive(Clone, Debug)]
pub struct Scope {
    /// Names and profiles of the devices: the swept ones at delays of 0, 1 and 2 ticks, then on
    /// request every shipped one at its own delay.
    cases: Vec<(String, DeviceProfile)>,
    ceilings: ceiling::Scope,
}

/// Devices that are run at every delay.
const SWEPT: [&str; 2] = ["touch", "frictionless"];

impl Scope {
    /// `quick` runs the Touch alone; `full` adds every shipped profile at its own delay.
    pub fn new(quick: bool, full: bool) -> Result<Self, Error> {
        let mut cases = Vec::new();
        for name in if quick { &SWEPT[..1] } else { &SWEPT[..] } {
            let device = DeviceProfile::load(name)?;
            for delay_ticks in 0..=2 {
                cases.push(((*name).to_owned(), DeviceProfile { delay_ticks, ..device.clone() }));
            }
        }
        if full {
            for (name, _) in palpate_loop::closed_loop::device::PROFILES.iter().filter(|(name, _)| !SWEPT.contains(name)) {
                cases.push(((*name).to_owned(), DeviceProfile::load(name)?));
            }
        }
        Ok(Self { cases, ceilings: ceiling::Scope::new(quick, full)? })
    }

    /// Number of cases, cells first and then ceilings, by which [`Part::measure`] numbers them.
    pub fn cases(&self) -> usize {
        self.cells() + self.ceilings.cases()
    }

    /// Number of steps that [`Part::measure`] reports for these cases.
    pub fn steps(&self, cases: Range<usize>) -> usize {
        let [cells, ceilings] = self.split(cases);
        cells.len() + self.ceilings.steps(ceilings)
    }

    fn cells(&self) -> usize {
        self.cases.len() * HANDS.len() * CONTROLLERS.len()
    }

    /// Splits case numbers into those of cells and those of ceilings.
    fn split(&self, cases: Range<usize>) -> [Range<usize>; 2] {
        let cells = self.cells();
        let beyond = |n: usize| n.saturating_sub(cells);
        [cases.start.min(cells)..cases.end.min(cells), beyond(cases.start)..beyond(cases.end)]
    }
}

/// Results of some of the cases.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Part {
    /// Cells of the matrix that this part measured.
    pub cells: Vec<Cell>,
    /// Measured ceilings, each with the stiffest tissue that one hand held.
    pub ceilings: Vec<Ceiling>,
}

/// All results of the loop matrix.
#[derive(Clone, Debug)]
pub struct LoopSummary {
    /// Cells of the matrix, by device, delay, hand and controller.
    pub cells: Vec<Cell>,
    /// Ceilings that the encoders allow.
    pub ceilings: Vec<Ceiling>,
    /// Promises that did not hold, one sentence each.
    pub broken: Vec<String>,
}

impl Part {
    /// Measures the cases with these numbers; `done` is called after every step.
    pub fn measure(scope: &Scope, cases: Range<usize>, done: &(impl Fn() + Sync)) -> Result<Self, Error> {
        let [cells, ceilings] = scope.split(cases);
        let all = scope
            .cases
            .iter()
            .flat_map(|(name, device)| CONTROLLERS.iter().flat_map(move |c| HANDS.map(|hand| (name, device, hand, *c))));
        let cases: Vec<_> = all.take(cells.end).skip(cells.start).collect();
        let measure = |(name, device, hand, control): &(&String, &DeviceProfile, Hand, Controller)| {
            let case = LoopSetup { device, hand: *hand, control: *control };
            let cell = Cell {
                device: (*name).clone(),
                delay_ticks: device.delay_ticks,
                hand: hand.id,
                control: control.name(),
                climb: case.climb()?,
                passive_n_per_m: passive_n_per_m(device),
                held: case.tap(HELD_N_PER_M)?,
            };
            done();
            Ok(cell)
        };
        let cells: Vec<Cell> = cases.par_iter().map(measure).collect::<Result<_, BuildError>>()?;
        Ok(Self { cells, ceilings: scope.ceilings.measure(ceilings, done)? })
    }
}

impl LoopSummary {
    /// Summarises the results of all cases.
    pub fn of(all: Part) -> Self {
        let broken = broken(&all.cells);
        Self { cells: all.cells, ceilings: ceiling::joined(all.ceilings), broken }
    }

    /// Cells of a device, a delay and a controller, one for each hand.
    fn row<'a, 'b>(&'a self, device: &'b str, delay_ticks: u8, control: &'b str) -> impl Iterator<Item = &'a Cell> + use<'a, 'b> {
        self.cells.iter().filter(move |c| c.device == device && c.delay_ticks == delay_ticks && c.control == control)
    }
}

/// Cells that break the promise: our controller holds [`HELD_N_PER_M`] in every hand without
/// creating energy and without static error, on the Touch at delays up to two ticks, on the
/// frictionless device up to one.
fn broken(cells: &[Cell]) -> Vec<String> {
    let promised =
        |c: &&Cell| c.control == Controller::Ours.name() && (c.device == SWEPT[0] || c.device == SWEPT[1] && c.delay_ticks <= 1);
    let mut broken = Vec::new();
    for cell in cells.iter().filter(promised) {
        let place = format!("{}, {} ticks late, {}, {HELD_N_PER_M} N/m", cell.device, cell.delay_ticks, cell.hand);
        let held = &cell.held;
        if !held.holds() || cell.climb.n_per_m * STEP < HELD_N_PER_M {
            broken.push(format!("{place}: held only up to {:.0} N/m", cell.climb.n_per_m));
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
