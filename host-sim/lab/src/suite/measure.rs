//! Errors of a method on one scene, held and moving.

use palpate::{Fault, Vector3};
use palpate_tissue::answer::Answer;
use palpate_tissue::error::Error as TissueError;
use palpate_tissue::moving::{Site, Truth};

use super::scenes::SuiteScene;
use crate::chart::{CLEAR_M, hold};
use crate::error::Error;
use crate::methods::{Block, Method, RunningMethod};

/// Speed of a held press [m/s].
const PRESS_M_PER_S: f64 = 0.04;
/// Ticks above the surface before a motion.
const LEAD_TICKS: i32 = 5;
/// Ticks after the end of a ramp that are compared.
const AFTER_TICKS: i32 = 20;

/// Root mean square of errors; `None` if there is none, or one is missing.
fn rms(errors: &[Option<f64>]) -> Option<f64> {
    let squares = errors.iter().map(|error| error.map(|pct| pct * pct)).sum::<Option<f64>>()?;
    (!errors.is_empty()).then(|| (squares / errors.len() as f64).sqrt())
}

/// Error of the held presses of a scene [%].
pub(super) fn held_pct(scene: &SuiteScene, method: Method, block: &Block, substeps: u16) -> Result<Option<f64>, Error> {
    if scene.held.is_empty() {
        return Ok(None);
    }
    let damaged = |_| TissueError::Check(format!("{}: its stored answer is damaged: take the file as it ships", scene.name));
    let answer: Answer = serde_json::from_str(scene.held).map_err(damaged)?;
    let [from_m, to_m] = scene.away_m;
    let holds = answer.holds.iter().filter(|hold| {
        let away_m = hold.place_m[0].hypot(hold.place_m[1]);
        (from_m - 1e-9..=to_m + 1e-9).contains(&away_m) && hold.depth_m >= 5e-4 && hold.depth_m <= 8e-3
    });
    let e_pa = f64::from(block.params.youngs_modulus_pa);
    let mut errors = Vec::new();
    for at in holds {
        let pressed = method.run(block, substeps, |running| -> Result<f64, Fault> {
            let mut moved = Moved { running, by_m: Vector3::from(at.place_m).cast() };
            let ticks = ((at.depth_m + CLEAR_M) / (PRESS_M_PER_S * 1e-3)).ceil() as i32;
            for n in 0..=ticks {
                moved.tick(block.tip_m((f64::from(n) * PRESS_M_PER_S * 1e-3 - CLEAR_M).min(at.depth_m)))?;
            }
            hold(block, &mut moved, at.depth_m)
        })?;
        errors.push(pressed.and_then(Result::ok).map(|force_n| 100.0 * (force_n / (e_pa * at.force_over_e_m2) - 1.0)));
    }
    Ok(rms(&errors))
}

/// Error of the motions of a scene [% of the peak].
pub(super) fn moving_pct(scene: &SuiteScene, method: Method, block: &Block, substeps: u16) -> Result<Option<f64>, Error> {
    let mut errors = Vec::new();
    for name in scene.motions {
        let truth = Truth::named(name).map_err(TissueError::from)?;
        let mut own = block.clone();
        own.params.youngs_modulus_pa = truth.youngs_modulus_pa as f32;
        let course = method.run(&own, substeps, |running| course_pct(&truth, &own, running))?;
        errors.push(course.transpose()?.flatten());
    }
    Ok(rms(&errors))
}

/// Error along a stored motion; of a ramp until 20 ms after its stop. `None` if the method
/// diverges.
fn course_pct(truth: &Truth, block: &Block, running: &mut dyn RunningMethod) -> Result<Option<f64>, Error> {
    let table = truth.stored().map_err(TissueError::from)?;
    let place_m = match truth.site {
        Site::Centre | Site::Nodule => [0.0; 2],
        Site::Aside => [0.00785, 0.0],
        Site::Askew => [0.0073, 0.0029],
    };
    let seconds = |n: i32| f64::from(n) * 1e-3;
    let end = (table.rows.last().map_or(0.0, |row| row.t_s) * 1e3).round() as i32;
    let stop = table.rows.iter().position(|row| row.depth_m >= 0.004 - 1e-9).map(|n| (table.rows[n].t_s * 1e3).round() as i32);
    let ramp = !["tap", "swing", "drag"].iter().any(|kind| truth.name.starts_with(kind));
    let last = stop.filter(|_| ramp).map_or(end, |stop| (stop + AFTER_TICKS).min(end));
    let first = table.at(seconds(1));
    let (mut squares, mut peak_m2) = (0.0, 0.0_f64);
    for n in -LEAD_TICKS..=last {
        let row = table.at(seconds(n));
        let depth_m = if n < 0 { f64::from(n) * first.depth_m } else { row.depth_m };
        let aside_m = Vector3::new((place_m[0] + row.across_m) as f32, place_m[1] as f32, 0.0);
        let Ok(force_n) = running.tick(block.tip_m(depth_m) + aside_m) else { return Ok(None) };
        if n > 0 {
            let own_m2 = f64::from(force_n.dot(&block.params.probe.axis)) / truth.youngs_modulus_pa;
            squares += (own_m2 - row.force_over_e_m2[2]).powi(2);
            peak_m2 = peak_m2.max(row.force_over_e_m2[2]);
        }
    }
    Ok(Some((squares / f64::from(last)).sqrt() / peak_m2 * 100.0))
}

/// A method that is pressed beside the site.
struct Moved<'a> {
    running: &'a mut dyn RunningMethod,
    by_m: Vector3<f32>,
}

impl RunningMethod for Moved<'_> {
    fn tick(&mut self, tip_m: Vector3<f32>) -> Result<Vector3<f32>, Fault> {
        self.running.tick(tip_m + self.by_m)
    }

    fn position_m(&self, node: usize) -> Vector3<f32> {
        self.running.position_m(node)
    }
}
