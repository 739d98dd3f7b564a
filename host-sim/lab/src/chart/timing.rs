//! Cost of a tick on this machine: CPU time of the thread, measured in batches while the tip moves
//! slowly about a depth of 4 mm.
//!
//! The tip moves because a warm-started solver has nothing left to solve in a hold. Batches of the
//! method alternate with batches of plain springs on the same mesh: the clock of a shared machine
//! drifts, but the ratio of neighbouring batches does not.

use palpate::Fault;
use serde::{Deserialize, Serialize};

use super::survive::CLEAR_M;
use crate::error::Error;
use crate::methods::{Block, Method, RunningMethod};
use palpate_tissue::clock::thread_time;

/// Depth about which the tip moves [m].
pub(super) const DEPTH_M: f64 = 0.004;
/// Displacement of the tip per tick [m], which is 20 mm/s.
pub(super) const STEP_M: f64 = 2e-5;
/// Number of ticks of a batch, of which half move down and half up.
pub(super) const BATCH_TICKS: usize = 10;
/// Displacement per tick on the way to that depth [m].
pub(super) const APPROACH_M: f64 = 1e-4;
/// Smallest number of batches, and CPU time after which no further batch is started [s].
pub(super) const LEAST_BATCHES: usize = 15;
pub(super) const LONG_ENOUGH_S: f64 = 0.1;
/// Number of ticks for which the press settles before timing starts.
pub(super) const SETTLE_TICKS: usize = 60;

/// CPU time of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TickTime {
    /// Time in the fastest batch [us].
    pub min_us: f64,
    /// Time in the median batch [us].
    pub median_us: f64,
    /// Time relative to that of plain springs with one substep on the same mesh (1): median over
    /// pairs of neighbouring batches.
    pub times_springs: f64,
    /// Floating-point operations of the solver in the last tick of batch number `LEAST_BATCHES`:
    /// counted there, they do not depend on how many batches this machine completes.
    pub solver_flops: f64,
}

/// Times a method. `None` if it is not available.
pub fn tick_time(method: Method, block: &Block, substeps: u16) -> Result<Option<Result<TickTime, Fault>>, Error> {
    let whole = block.clone().refined(1);
    let timed =
        Method::Springs.run(&whole, 1, |springs| method.run(block, substeps, |running| in_turn(block, running, springs)))?;
    Ok(timed.transpose().map(Option::flatten)?)
}

fn in_turn(block: &Block, running: &mut dyn RunningMethod, springs: &mut dyn RunningMethod) -> Result<TickTime, Fault> {
    settle(block, running)?;
    settle(block, springs)?;
    let begun = thread_time();
    let mut batches_us = Vec::new();
    let mut ratios = Vec::new();
    let mut solver_flops = 0.0;
    while batches_us.len() < LEAST_BATCHES || (thread_time() - begun).as_secs_f64() < LONG_ENOUGH_S {
        let (plain_us, own_us) = (batch_us(block, springs)?, batch_us(block, running)?);
        batches_us.push(own_us);
        ratios.push(own_us / plain_us);
        if batches_us.len() == LEAST_BATCHES {
            solver_flops = running.solver_flops();
        }
    }
    batches_us.sort_by(f64::total_cmp);
    ratios.sort_by(f64::total_cmp);
    Ok(TickTime {
        min_us: batches_us[0],
        median_us: batches_us[batches_us.len() / 2],
        times_springs: ratios[ratios.len() / 2],
        solver_flops,
    })
}

fn settle(block: &Block, running: &mut dyn RunningMethod) -> Result<(), Fault> {
    let down = ((DEPTH_M + CLEAR_M) / APPROACH_M).ceil() as usize;
    for n in 0..=down + SETTLE_TICKS {
        running.tick(block.tip_m((n as f64 * APPROACH_M - CLEAR_M).min(DEPTH_M)))?;
    }
    Ok(())
}

/// Mean CPU time of a tick in one batch [us].
fn batch_us(block: &Block, running: &mut dyn RunningMethod) -> Result<f64, Fault> {
    let started = thread_time();
    for n in 1..=BATCH_TICKS {
        let from_start = n.min(BATCH_TICKS - n);
        running.tick(block.tip_m(DEPTH_M + from_start as f64 * STEP_M))?;
    }
    Ok((thread_time() - started).as_secs_f64() * 1e6 / BATCH_TICKS as f64)
}
