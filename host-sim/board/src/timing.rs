//! Cost of a tick on the board: exact instruction counts, and their estimated cycles on a
//! Cortex-M4F.
//!
//! **Neither is hardware timing**: no pipeline, no flash wait states, no bus contention.

use std::io::BufReader;
use std::path::Path;

use palpate::Vector3;
use palpate_controller::link::message::HostAsk;
use palpate_controller::patch::Memory;

use super::exec_log::ExecLog;
use super::firmware_image::FirmwareImage;
use super::instruction_mix::calls_of;
use super::twin::Reading;
use super::{Board, EmulateError, EmulatedBoard, Lockstep};

/// Path of the core's tick in the image.
const TICK: &str = "palpate::tick::tick";
/// Number of ticks that are logged: the patch is put to rest, waits, and is tapped before the force
/// is enabled.
const WAIT_TICKS: u32 = 4;
const TAP_TICKS: u32 = 22;
/// Height at which the tap begins, and displacement of the tip per tick [m].
const CLEAR_M: f32 = 0.6e-3;
const STEP_M: f32 = 0.23e-3;

/// Mean number of cycles per instruction in the costliest tick of a tap, by the reference manual's
/// table for the executed instructions.
///
/// # Errors
/// The board crashed, or the image does not have the function.
pub fn cycles_per_instruction(image: &Path, machine: EmulatedBoard, patch: &[u8]) -> Result<f64, EmulateError> {
    let folder = tempfile::tempdir()?;
    let log = folder.path().join("executed");
    let mut memory = Box::new(Memory::RESERVED);
    let mut twin = Lockstep::new(Board::start(image, machine, Some(&log))?, patch, &mut memory)?;
    for n in 0..WAIT_TICKS + TAP_TICKS {
        let down_m = STEP_M * n.saturating_sub(WAIT_TICKS) as f32;
        twin.tick(Reading::at(Vector3::new(0.0, 0.0, CLEAR_M - down_m)), (n == 0).then_some(HostAsk::Arm))?;
    }
    drop(twin); // the log is complete once the emulator has ended
    let image = FirmwareImage::parse(&std::fs::read(image)?)?;
    let executed = ExecLog::new(BufReader::new(std::fs::File::open(&log)?));
    let ticks = calls_of(TICK, &image, executed)?;
    let costs = ticks.iter().map(|tick| (tick.total().cycles(), tick.total().instructions()));
    let (cycles, instructions) = costs.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 1));
    Ok(cycles / instructions as f64)
}

/// Distribution of the instructions per tick over a run.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Spread {
    /// Median over the ticks that run the patch.
    pub median: u64,
    /// Instructions of the longest tick.
    pub max: u64,
    /// Longest tick relative to the median (1).
    pub worst_over_median: f64,
    /// Number of ticks that do not run the patch (start-up, idle, fault); the median leaves them
    /// out.
    pub without_patch: usize,
}

impl Spread {
    /// Summarises all ticks of a run. A tick with at most half the instructions of the longest did
    /// not run the patch.
    #[must_use]
    pub fn of(instructions: &[u64]) -> Self {
        let max = instructions.iter().copied().max().unwrap_or(0);
        let mut with_patch: Vec<u64> = instructions.iter().copied().filter(|n| 2 * n > max).collect();
        with_patch.sort_unstable();
        let median = with_patch.get(with_patch.len() / 2).copied().unwrap_or(0);
        let without_patch = instructions.len() - with_patch.len();
        Self { median, max, worst_over_median: max as f64 / median.max(1) as f64, without_patch }
    }
}

/// Histogram of instructions per tick, ascending.
#[must_use]
pub fn histogram(instructions: &[u64]) -> Vec<[f64; 2]> {
    let mut counts = std::collections::BTreeMap::new();
    for n in instructions {
        *counts.entry(*n).or_insert(0_u32) += 1;
    }
    counts.into_iter().map(|(instructions, ticks)| [instructions as f64, f64::from(ticks)]).collect()
}
