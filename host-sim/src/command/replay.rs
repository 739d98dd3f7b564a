//! `palpate live --replay`: a recorded trace once more, bit for bit.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::on_demand::{Program, build_and_run};
use super::options::EmulatedBoard;
use super::verdict::Verdict;
use crate::error::Error;
use crate::provenance;
#[cfg(feature = "full")]
use palpate_board::{live_trace, one_core::OneCore};
use palpate_loop::closed_loop::watch::Broken;
use palpate_loop::live::replay::{self, Replayed};
use palpate_loop::live::trace::{Head, Trace, VERSION};
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

#[derive(Args, Clone, Debug)]
pub(super) struct ReplayArgs {
    /// Run a trace that was recorded in the window or in the page once more, without either, and
    /// compare it bit for bit.
    #[arg(long = "replay", value_name = "TRACE", conflicts_with_all = ["scene", "follow", "page"])]
    pub file: Option<PathBuf>,
    /// Also replay it on the emulated board, in lock-step: every tick must have the trace's bits.
    #[arg(long, requires = "file")]
    emulated: bool,
    /// Firmware image [default: built with `cargo fw`, with a large patch in its flash].
    #[arg(long, value_name = "FILE", requires = "emulated")]
    image: Option<PathBuf>,
    /// The emulated board.
    #[arg(long, value_enum, default_value = "m7-480", requires = "emulated")]
    board: EmulatedBoard,
}

/// Contents of `summary.json`.
#[derive(Serialize)]
struct Summary<'a> {
    trace_version: u32,
    #[serde(flatten)]
    head: &'a Head,
    ticks: u32,
    peak_force_n: f32,
    deepest_m: f32,
    state_hash: String,
    same_bits: bool,
    emulated_board: Option<&'static str>,
    differs_at_tick: Option<u32>,
    differs_in: Option<&'static str>,
    /// Invariants of the loop that ticks of the trace break.
    invariants_broken: Vec<&'static str>,
}

impl ReplayArgs {
    /// Replays a trace into the folder `out`.
    pub(super) fn run(&self, file: &Path, out: &Path) -> Result<(), Error> {
        if self.emulated && cfg!(not(feature = "full")) {
            return build_and_run(Program::Full);
        }
        let bytes = std::fs::read(file).map_err(|source| TissueError::Read { path: file.to_owned(), source })?;
        let trace = Trace::read(&bytes).map_err(|cause| Error::Trace { path: file.to_owned(), cause })?;
        let folder = OutputFolder::open(out)?.made_by(provenance::of(None));
        let again = self.again(&trace)?;
        let peak_force_n = again.telemetry.iter().map(|t| t.applied_n.norm()).fold(0.0, f32::max);
        let deepest_m = again.telemetry.iter().map(|t| t.output.depth_m).fold(0.0, f32::max);
        let summary = Summary {
            trace_version: VERSION,
            head: &trace.head,
            ticks: trace.ticks,
            peak_force_n,
            deepest_m,
            state_hash: format!("{:016x}", again.hash),
            same_bits: again.differs.is_none(),
            emulated_board: self.emulated.then(|| self.board.name()),
            differs_at_tick: again.differs.map(|d| d.0),
            differs_in: again.differs.map(|d| d.1),
            invariants_broken: again.broken.iter().map(|(b, _)| b.id).collect(),
        };
        folder.write_summary(&summary)?;
        folder.write("trace.csv", replay::table(&again).as_bytes())?;
        let verdict = Verdict::of(judge(file, &again), || {
            let boards = if self.emulated { ", on this machine and on the emulated board" } else { "" };
            format!("all {} ticks have the trace's bits{boards}", trace.ticks)
        })?
        .first();
        let seconds = f64::from(trace.ticks) * 1e-3;
        println!("{}: {} with {}, {seconds:.1} s", file.display(), trace.head.scene, trace.head.device);
        println!(
            "  strongest {peak_force_n:.3} N, deepest {:.2} mm; checksum of every node's state at the end {:016x}",
            deepest_m * 1e3,
            again.hash
        );
        println!("\nwrote {}: summary.json, trace.csv", folder.publish()?.display());
        verdict.last()
    }

    #[cfg(feature = "full")]
    fn again(&self, trace: &Trace) -> Result<Replayed, Error> {
        if !self.emulated {
            return Ok(replay::replay(trace)?);
        }
        let turns = OneCore::stay();
        let again = live_trace::replay(trace, self.image.as_deref(), self.board.into())?;
        drop(turns);
        Ok(again)
    }

    #[cfg(not(feature = "full"))]
    #[expect(clippy::unused_self, reason = "the build with a board asks it")]
    fn again(&self, trace: &Trace) -> Result<Replayed, Error> {
        Ok(replay::replay(trace)?)
    }
}

/// Checks that no invariant was broken and that no bit differs from the trace.
fn judge(file: &Path, again: &Replayed) -> Result<(), Error> {
    let file = file.display();
    if let Some((Broken { id, what }, tick)) = again.broken.first() {
        return Err(TissueError::Check(format!("{file}: tick {tick} breaks {id}: {what}")).into());
    }
    match again.differs {
        None => Ok(()),
        Some((tick, what)) => Err(TissueError::Check(format!("{file}: {what} differs at tick {tick}")).into()),
    }
}
