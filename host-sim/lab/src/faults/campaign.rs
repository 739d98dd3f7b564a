//! The fault campaign injects every kind of fault, with every hand, at every moment of a touch, on
//! a wall and on a patch, and checks every tick.
//!
//! A [`Case`] describes one run and is derived from its number; a [`Bed`] is a loop that is armed
//! once and copied for every run. Nothing here reads a clock, so the same number and seed always
//! give the same run.

mod case;
mod inject;
mod run;
mod state;
mod table;
mod verdict;

pub use case::{Case, MOTIONS, Moment, Motion};
pub use run::Bed;
pub use state::Outcome;
pub use table::{Row, Table};

use std::ops::Range;

use palpate::{BuildError, Params};
use rayon::prelude::*;

use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::surface::{Wall, force_at_n, static_curve, with_tissue};
use palpate_tissue::patch::Patch;

/// Smallest and largest number of runs in the batch that a thread executes at a time. Each batch
/// arms a loop over its own wall and patch, which takes as long as four runs.
const BATCH: [u64; 2] = [64, 4096];
/// Batches per thread, if there are enough runs: small batches let all threads finish at about the
/// same time.
const BATCHES_PER_THREAD: u64 = 32;
/// Stiffness of the wall [N/m]: the stiffness ceiling of the default device.
pub const WALL_N_PER_M: f64 = 400.0;
/// Depth at which a press rests [m].
pub const DEPTH_M: f64 = 4e-3;

/// Number of nodes, Young's modulus [Pa] and deepest press [m] of the patch.
const NODES: usize = 130;
const YOUNGS_MODULUS_PA: f32 = 20e3;
const DEEPEST_M: f32 = 8e-3;

/// Device and patch that the runs use.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// Profile of the device.
    pub device: &'a DeviceProfile,
    /// Patch that half of the runs touch.
    pub patch: &'a Patch,
    /// Parameters of the patch.
    pub params: &'a Params,
    /// Force of the patch at [`DEPTH_M`] [N].
    pub patch_n: f64,
}

impl<'a> Ground<'a> {
    /// Prepares a campaign with this device on this patch.
    pub fn new(device: &'a DeviceProfile, light: &'a LightPatch) -> Self {
        Self { device, patch: &light.patch, params: &light.params, patch_n: light.static_n }
    }
}

/// Runs the cases with these numbers and this seed, about half of them on a wall and the rest on
/// the patch. `done` is called with the number of runs after every batch. The tables of parts of a
/// range add up to the table of the whole range.
pub fn campaign(ground: &Ground, cases: Range<u64>, seed: u64, done: impl Fn(u64) + Sync) -> Result<Table, BuildError> {
    let share = (cases.end - cases.start) / (BATCHES_PER_THREAD * rayon::current_num_threads() as u64);
    let length = share.clamp(BATCH[0], BATCH[1]);
    // tables are added as they arrive: if all were stored, they would fill the memory at some 1e8
    // runs
    batches(cases, length).map(|numbers| part(ground, numbers, seed, &done)).try_reduce(Table::default, |mut table, more| {
        table.add(&more);
        Ok(table)
    })
}

/// Splits a range into batches for parallel work.
pub(super) fn batches(cases: Range<u64>, length: u64) -> impl ParallelIterator<Item = Range<u64>> {
    let count = (cases.end - cases.start).div_ceil(length);
    (0..count).into_par_iter().map(move |batch| {
        let start = cases.start + batch * length;
        start..cases.end.min(start + length)
    })
}

fn part(ground: &Ground, numbers: Range<u64>, seed: u64, done: &(impl Fn(u64) + Sync)) -> Result<Table, BuildError> {
    let cases: Vec<Case> = numbers.clone().map(|n| Case::draw(n, seed)).collect();
    let mut table = Table::default();
    let mut wall = Wall::new(WALL_N_PER_M, ground.device.force_limit_n, Case::WALL_NORMAL);
    let bed = Bed::arm(ground.device, &mut wall, WALL_N_PER_M * DEPTH_M)?;
    for case in cases.iter().filter(|c| !c.on_patch) {
        table.count(case, &bed.run(case, &mut wall)?);
    }
    with_tissue(ground.patch, ground.params, |tissue| {
        let bed = Bed::arm(ground.device, tissue, ground.patch_n)?;
        for case in cases.iter().filter(|c| c.on_patch) {
            table.count(case, &bed.run(case, tissue)?);
        }
        Ok(())
    })??;
    done(numbers.end - numbers.start);
    Ok(table)
}

/// A patch that is cheap enough for the campaign.
#[derive(Clone, Debug)]
pub struct LightPatch {
    /// Calibrated patch of 130 nodes.
    pub patch: Patch,
    /// One step per tick, as on the board: the campaign tests the loop, not the patch.
    pub params: Params,
    /// Force of the patch at [`DEPTH_M`] [N].
    pub static_n: f64,
}

impl LightPatch {
    /// Loads the shipped patch of 130 nodes at 20 kPa, with one step per tick, which is cheap
    /// enough for a hundred million runs.
    pub fn load() -> Result<Self, BuildError> {
        let Some((mut patch, packed)) = palpate_tissue::session::calibrated::sized(NODES) else {
            return Err(BuildError::NotAPatch);
        };
        patch.set_depth_limit_m(DEEPEST_M);
        let limits = palpate_tissue::stable_step::limits(&patch, f64::from(packed.tick_s));
        let params = Params { youngs_modulus_pa: YOUNGS_MODULUS_PA, limits, substeps: 1, ..packed };
        let curve = static_curve(&patch, &params)?;
        Ok(Self { static_n: force_at_n(&curve, DEPTH_M), patch, params })
    }
}
