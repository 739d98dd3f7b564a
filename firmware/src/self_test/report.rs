//! The findings as one line of JSON, which a person can send and a program can compare.

use core::fmt::{self, Write};

use palpate_controller::board::About;
use palpate_controller::snapshot::Snapshot;
use palpate_controller::words;

use super::stages::{self, Times};
use crate::board;

/// Number of fingerprints per run.
pub const CHECKS: usize = 8;
/// Longest report [bytes].
const BYTES: usize = 2_048;

/// Hashes after a number of ticks.
#[derive(Clone, Copy)]
pub struct Check {
    /// Number of ticks so far.
    pub tick: u32,
    /// Hash of all node positions and velocities.
    pub state_hash: u64,
    /// Hash of the forces of all ticks so far.
    pub force_hash: u64,
}

/// Findings of a run.
#[derive(Clone, Copy)]
pub struct Findings {
    /// Reason for which the test did not run; empty if it ran.
    pub error: &'static str,
    /// Number of ticks in the run.
    pub ticks: u32,
    /// Number of nodes of the patch.
    pub nodes: usize,
    /// Checksum of the patch file.
    pub checksum: u32,
    /// Fingerprints during the run.
    pub checks: [Check; CHECKS],
    /// Counters at the end of the run.
    pub seen: Snapshot,
    /// Whether the loop was in the mode `Active` at the end of the run.
    pub reached_force: bool,
    /// Largest stack use so far [bytes].
    pub stack_used_bytes: usize,
    /// Longest duration of each stage of the core's tick.
    pub stages: Times,
}

impl Findings {
    /// State before a run.
    pub const NONE: Self = Self {
        error: "",
        ticks: 0,
        nodes: 0,
        checksum: 0,
        checks: [Check { tick: 0, state_hash: 0, force_hash: 0 }; CHECKS],
        seen: Snapshot::START,
        reached_force: false,
        stack_used_bytes: 0,
        stages: stages::NONE,
    };

    /// Whether the run ended with an active force and without faults and late ticks. The desktop
    /// compares its bits.
    pub fn passed(&self) -> bool {
        self.error.is_empty() && self.reached_force && self.seen.faults == 0 && self.seen.overruns == 0
    }
}

/// The line of the report, with a line break at both ends, so that earlier bytes on the link do not
/// become part of it.
pub struct Report {
    bytes: [u8; BYTES],
    length: usize,
}

impl Write for Report {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let place = self.bytes.get_mut(self.length..self.length + text.len()).ok_or(fmt::Error)?;
        place.copy_from_slice(text.as_bytes());
        self.length += text.len();
        Ok(())
    }
}

impl Report {
    /// A report without content.
    pub const EMPTY: Self = Self { bytes: [0; BYTES], length: 0 };

    /// Writes the findings. A report that does not fit is truncated, and hosts reject it as
    /// incomplete JSON.
    #[inline(never)]
    pub fn fill(&mut self, findings: &Findings) {
        let _ = self.write(findings);
    }

    /// The line, without its breaks.
    pub fn text(&self) -> &str {
        core::str::from_utf8(self.line()).unwrap_or_default().trim()
    }

    /// The line as it is sent over the link.
    pub fn line(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }

    fn write(&mut self, found: &Findings) -> fmt::Result {
        let About { name, built_day, clock_hz, .. } = board::about();
        let (chip, [set, needed]) = board::chip();
        let Snapshot { longest_tick_counts, overruns, missed_periods, faults, fault, mode, .. } = found.seen;
        write!(self, "\n{{\"palpate_self_test\":1,\"board\":\"{name}\",\"built_day\":{built_day},\"chip\":\"{chip:08x}\"")?;
        write!(self, ",\"brown_out\":[{set},{needed}]")?;
        write!(self, ",\"clock\":\"{}\",\"clock_hz\":{clock_hz}", board::CLOCK_KIND)?;
        write!(self, ",\"patch_checksum\":\"{:08x}\",\"nodes\":{}", found.checksum, found.nodes)?;
        write!(self, ",\"error\":\"{}\",\"passed\":{},\"mode\":\"{}\"", found.error, found.passed(), words::mode(mode))?;
        write!(self, ",\"fault\":\"{}\",\"ticks\":{},\"faults\":{faults}", words::fault(fault), found.ticks)?;
        write!(self, ",\"overruns\":{overruns},\"missed_periods\":{missed_periods}")?;
        write!(self, ",\"worst_tick_counts\":{longest_tick_counts}")?;
        write!(self, ",\"stack_used_bytes\":{},\"stack_bytes\":{}", found.stack_used_bytes, board::STACK_BYTES)?;
        write!(self, ",\"stage_counts\":{{")?;
        for (at, (stage, counts)) in found.stages.iter().enumerate() {
            write!(self, "{}\"{stage}\":{counts}", if at == 0 { "" } else { "," })?;
        }
        write!(self, "}},\"checks\":[")?;
        for (at, Check { tick, state_hash, force_hash }) in found.checks.iter().enumerate() {
            let comma = if at == 0 { "" } else { "," };
            write!(self, "{comma}{{\"tick\":{tick},\"state\":\"{state_hash:016x}\",\"forces\":\"{force_hash:016x}\"}}")?;
        }
        writeln!(self, "]}}")
    }
}
