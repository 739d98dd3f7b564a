//! Slides along the surface: with friction and back, and through tissue that relaxes.

use palpate::{Params, Vector3};
use palpate_tissue::error::Error as TissueError;
use palpate_tissue::moving::Table;
use palpate_tissue::scene::Scene;

use super::measure::{LEAD_TICKS, rms};
use super::own::table;
use crate::chart::CLEAR_M;
use crate::error::Error;
use crate::methods::{Block, Method, RunningMethod};

/// Depth of the slide [m], speed on the way in, and ticks at rest before it starts.
const DEPTH_M: f64 = 2e-3;
const IN_M_PER_S: f64 = 0.1;
const SETTLE_TICKS: usize = 400;
/// Friction coefficient (1), length of the slide [m] and its speed [m/s].
const FRICTION: f64 = 0.46;
const SLIDE_M: f64 = 6e-3;
const SLIDE_M_PER_S: f64 = 0.02;
/// Length of the last part of each way, over which forces are averaged [m].
const AVERAGED_M: f64 = 3e-3;
/// Name of the table of the press that relaxes, slides and returns.
pub const RETURN: &str = "return";

/// The block with friction, or with the relaxation of beef; a method without the term has neither.
fn with_terms(method: Method, block: &Block, change: impl Fn(Params) -> Params) -> Block {
    // springs alone are the model of a paper, so they are not counted as ours here
    let ours = method.is_ours() && method != Method::Springs;
    let params = if ours { change(block.params) } else { block.params };
    Block { params, ..block.clone() }
}

/// Error of the force along the surface over the normal force, there and back, against Coulomb's
/// law [%].
pub(super) fn friction_pct(method: Method, block: &Block, substeps: u16) -> Result<Option<f64>, Error> {
    let own = with_terms(method, block, |params| Params { friction: FRICTION as f32, ..params });
    let ratios = method.run(&own, substeps, |running| there_and_back(&own, running))?.flatten();
    Ok(rms(&[0, 1].map(|n| Some(100.0 * (ratios?[n] / FRICTION - 1.0)))))
}

/// Force against the slide over the normal force, on the last part of each way (1).
fn there_and_back(block: &Block, running: &mut dyn RunningMethod) -> Option<[f64; 2]> {
    let step_m = IN_M_PER_S * 1e-3;
    let down = ((DEPTH_M + CLEAR_M) / step_m).ceil() as usize;
    for n in 0..=down + SETTLE_TICKS {
        running.tick(block.tip_m((n as f64 * step_m - CLEAR_M).min(DEPTH_M))).ok()?;
    }
    let ticks = (SLIDE_M / (SLIDE_M_PER_S * 1e-3)).round() as usize;
    let averaged = (AVERAGED_M / (SLIDE_M_PER_S * 1e-3)).round() as usize;
    let mut ratios = [0.0; 2];
    for (back, ratio) in ratios.iter_mut().enumerate() {
        let (mut against, mut push) = (0.0, 0.0);
        for n in 1..=ticks {
            let slid = n as f64 / ticks as f64;
            let x_m = SLIDE_M * if back == 1 { 1.0 - slid } else { slid };
            let force_n = running.tick(block.tip_m(DEPTH_M) + Vector3::new(x_m as f32, 0.0, 0.0)).ok()?;
            if n + averaged > ticks {
                against += f64::from(force_n.x) * if back == 1 { 1.0 } else { -1.0 };
                push += f64::from(force_n.dot(&block.params.probe.axis));
            }
        }
        *ratio = against / push;
    }
    Some(ratios)
}

/// Error of the normal force from the start of the first hold on, in tissue that relaxes like beef
/// and is pressed, slid along and returned to [% of the largest force].
pub(super) fn return_pct(method: Method, block: &Block, substeps: u16) -> Result<Option<f64>, Error> {
    let relaxation = Scene::load("beef").map_err(TissueError::from)?.tissue.relaxation();
    let own = with_terms(method, block, |params| Params { relaxation, ..params });
    let table = table(RETURN)?;
    Ok(method.run(&own, substeps, |running| along(&table, &own, running))?.flatten())
}

fn along(table: &Table, block: &Block, running: &mut dyn RunningMethod) -> Option<f64> {
    let end = (table.rows.last()?.t_s * 1e3).round() as i32;
    let deepest_m = table.rows.iter().map(|row| row.depth_m).fold(0.0, f64::max);
    let e_pa = f64::from(block.params.youngs_modulus_pa);
    let (mut squares, mut count, mut peak_m2) = (0.0, 0.0, 0.0_f64);
    let first_m = table.at(1e-3).depth_m;
    for n in -LEAD_TICKS..=end {
        let row = table.at(f64::from(n) * 1e-3);
        let depth_m = if n < 0 { f64::from(n) * first_m } else { row.depth_m };
        let force_n = running.tick(block.tip_m(depth_m) + Vector3::new(row.across_m as f32, 0.0, 0.0)).ok()?;
        peak_m2 = peak_m2.max(row.force_over_e_m2[2]);
        if row.depth_m >= deepest_m - 1e-9 {
            squares += (f64::from(force_n.dot(&block.params.probe.axis)) / e_pa - row.force_over_e_m2[2]).powi(2);
            count += 1.0;
        }
    }
    Some((squares / count).sqrt() / peak_m2 * 100.0)
}
