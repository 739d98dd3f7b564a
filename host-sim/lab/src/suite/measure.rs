//! Errors of a method on one tissue, held and moving.

use palpate::{Fault, Vector3};
use palpate_tissue::answer::HoldAnswer;
use palpate_tissue::error::Error as TissueError;
use palpate_tissue::moving::table::Row;
use palpate_tissue::moving::{Site, Table, Truth};

use super::own::place_m;
use crate::chart::{CLEAR_M, hold};
use crate::error::Error;
use crate::methods::{Block, Method, RunningMethod};

/// Speed of a held press [m/s].
const PRESS_M_PER_S: f64 = 0.04;
/// Ticks above the surface before a motion.
pub(super) const LEAD_TICKS: i32 = 5;
/// Ticks after the end of a ramp that are compared.
const AFTER_TICKS: i32 = 20;

/// Root mean square of errors; `None` if there is none, or one is missing.
pub(super) fn rms(errors: &[Option<f64>]) -> Option<f64> {
    let squares = errors.iter().map(|error| error.map(|pct| pct * pct)).sum::<Option<f64>>()?;
    (!errors.is_empty()).then(|| (squares / errors.len() as f64).sqrt())
}

/// Errors of held presses [%]; `None` where the method diverges.
pub(super) fn held_pct<'h>(
    holds: impl IntoIterator<Item = &'h HoldAnswer>,
    method: Method,
    block: &Block,
    substeps: u16,
) -> Result<Vec<Option<f64>>, Error> {
    let e_pa = f64::from(block.params.youngs_modulus_pa);
    let mut errors = Vec::new();
    for at in holds {
        let by_m = place_m(block, method, at.place_m).cast();
        let pressed = method.run(block, substeps, |running| -> Result<f64, Fault> {
            let mut moved = Moved { running, by_m };
            let ticks = ((at.depth_m + CLEAR_M) / (PRESS_M_PER_S * 1e-3)).ceil() as i32;
            for n in 0..=ticks {
                moved.tick(block.tip_m((f64::from(n) * PRESS_M_PER_S * 1e-3 - CLEAR_M).min(at.depth_m)))?;
            }
            hold(block, &mut moved, at.depth_m)
        })?;
        errors.push(pressed.and_then(Result::ok).map(|force_n| 100.0 * (force_n / (e_pa * at.force_over_e_m2) - 1.0)));
    }
    Ok(errors)
}

/// Errors of the stored motions with these names [% of the peak].
pub(super) fn stored_motions_pct(
    names: &[&str],
    method: Method,
    block: &Block,
    substeps: u16,
) -> Result<Vec<Option<f64>>, Error> {
    let mut errors = Vec::new();
    for name in names {
        let truth = Truth::named(name).map_err(TissueError::from)?;
        let table = truth.stored().map_err(TissueError::from)?;
        let mut own = block.clone();
        own.params.youngs_modulus_pa = truth.youngs_modulus_pa as f32;
        let at_m = match truth.site {
            Site::Centre | Site::Nodule => [0.0; 3],
            Site::Aside => [0.00785, 0.0, 0.0],
            Site::Askew => [0.0073, 0.0029, 0.0],
        };
        errors.push(ramp_pct(&table, at_m, method, &own, substeps)?);
    }
    Ok(errors)
}

/// Error along a motion, of a ramp until 20 ms after its stop [% of the peak]. `None` if the method
/// diverges.
pub(super) fn ramp_pct(
    table: &Table,
    at_m: [f64; 3],
    method: Method,
    block: &Block,
    substeps: u16,
) -> Result<Option<f64>, Error> {
    let by_m = place_m(block, method, at_m).cast();
    let course = method.run(block, substeps, |running| course_pct(table, block, &mut Moved { running, by_m }))?;
    Ok(course.flatten())
}

fn course_pct(table: &Table, block: &Block, running: &mut dyn RunningMethod) -> Option<f64> {
    let seconds = |n: i32| f64::from(n) * 1e-3;
    let ticks = |t_s: f64| (t_s * 1e3).round() as i32;
    let deepest_m = table.rows.iter().map(|row| row.depth_m).fold(0.0, f64::max);
    let stop = table.rows.iter().find(|row| row.depth_m >= deepest_m - 1e-9).map_or(0, |row| ticks(row.t_s));
    let end = table.rows.last().map_or(0, |row| ticks(row.t_s));
    // a ramp stays where it stopped
    let stays = |row: &Row| row.depth_m >= deepest_m - 1e-9 || row.t_s * 1e3 <= f64::from(stop);
    let ramp = table.rows.iter().all(|row| row.across_m == 0.0 && stays(row));
    let last = if ramp { (stop + AFTER_TICKS).min(end) } else { end };
    let first = table.at(seconds(1));
    let e_pa = f64::from(block.params.youngs_modulus_pa);
    let (mut squares, mut peak_m2) = (0.0, 0.0_f64);
    for n in -LEAD_TICKS..=last {
        let row = table.at(seconds(n));
        let depth_m = if n < 0 { f64::from(n) * first.depth_m } else { row.depth_m };
        let across_m = Vector3::new(row.across_m as f32, 0.0, 0.0);
        let force_n = running.tick(block.tip_m(depth_m) + across_m).ok()?;
        if n > 0 {
            let own_m2 = f64::from(force_n.dot(&block.params.probe.axis)) / e_pa;
            squares += (own_m2 - row.force_over_e_m2[2]).powi(2);
            peak_m2 = peak_m2.max(row.force_over_e_m2[2]);
        }
    }
    Some((squares / f64::from(last)).sqrt() / peak_m2 * 100.0)
}

/// A method that is pressed beside the site.
pub(super) struct Moved<'a> {
    pub running: &'a mut dyn RunningMethod,
    pub by_m: Vector3<f32>,
}

impl RunningMethod for Moved<'_> {
    fn tick(&mut self, tip_m: Vector3<f32>) -> Result<Vector3<f32>, Fault> {
        self.running.tick(tip_m + self.by_m)
    }

    fn position_m(&self, node: usize) -> Vector3<f32> {
        self.running.position_m(node)
    }
}
