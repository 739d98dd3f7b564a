//! The report of a self-test image, and the comparison with the same run on this machine.
//!
//! ```text
//! text of a port or a file ─ Report::find ─ compare (script, controller and patch run here)─ words
//! ```

use std::collections::BTreeMap;
use std::fmt::Write as _;

use palpate::haptic::cycle::Command;
use palpate::{BuildError, Fnv};
use palpate_controller::config::Profile;
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::patch::{Memory, Patch};
use palpate_controller::script::{self, LEAD_TICKS};
use serde::Deserialize;

/// Key that begins every report, after the brace.
const KEY: &str = "{\"palpate_self_test\":";
/// Largest number of ticks that are run here for a report: a minute of the board's time.
const MOST_TICKS: u32 = 60_000;

/// Report of a board, as its image wrote it.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct Report {
    /// Version of this format.
    pub palpate_self_test: u32,
    /// Board and version of its image.
    pub board: String,
    /// Day of the build, counted from 1970-01-01; 0 if unknown.
    pub built_day: u32,
    /// Identification that the chip itself gives: revision in the upper half, device in the lower
    /// half.
    pub chip: String,
    /// Brown-out level that is set in the chip, and that its clocks need.
    #[serde(default)]
    pub brown_out: [u8; 2],
    /// Meaning of a count of the clock.
    pub clock: String,
    /// Counts of the clock per second.
    pub clock_hz: u32,
    /// Checksum of the patch file.
    pub patch_checksum: String,
    /// Nodes of the patch.
    pub nodes: u32,
    /// Reason why the test did not run; empty if it ran.
    pub error: String,
    /// Whether the run passed on the board.
    pub passed: bool,
    /// Mode at the end of the run.
    pub mode: String,
    /// Fault at the end of the run.
    pub fault: String,
    /// Number of ticks in the run.
    pub ticks: u32,
    /// Number of ticks in the mode `Fault`.
    pub faults: u32,
    /// Number of ticks that ended late.
    pub overruns: u32,
    /// Number of periods without a tick.
    pub missed_periods: u32,
    /// Longest tick, from sensors to outputs [counts].
    pub worst_tick_counts: u32,
    /// Largest stack use [bytes].
    pub stack_used_bytes: u32,
    /// Size of the stack [bytes].
    pub stack_bytes: u32,
    /// Longest duration of each stage [counts].
    pub stage_counts: BTreeMap<String, u32>,
    /// Fingerprints taken during the run.
    pub checks: Vec<Check>,
}

/// Fingerprints after this many ticks, as hexadecimal numbers.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct Check {
    /// Number of ticks before the fingerprint.
    pub tick: u32,
    /// Hash of the patch's state.
    pub state: String,
    /// Hash of the forces of all ticks.
    pub forces: String,
}

/// The first word in which a board and this machine differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Number of ticks before the word was taken; the fingerprints before it agree.
    pub tick: u32,
    /// Name of the word.
    pub word: &'static str,
    /// Value on the board.
    pub board: String,
    /// Value on this machine.
    pub here: String,
}

impl Report {
    /// The last complete report in a text, and its line. Other text may surround the line.
    pub fn find(text: &str) -> Option<(Self, &str)> {
        text.lines().rev().find_map(|line| {
            let line = line.get(line.find(KEY)?..)?.trim_end();
            Some((serde_json::from_str(line).ok()?, line))
        })
    }

    /// Runs the same script on this machine and returns the first difference; `None` means the same
    /// bits. `patch` is the patch file, aligned to a word.
    pub fn compare(&self, patch: &[u8]) -> Result<Option<Difference>, BuildError> {
        let mut memory = Box::new(Memory::RESERVED);
        let mut patch = Patch::open(patch, &mut memory, None)?;
        let (settings, edge) = Profile::desktop().split();
        let mut controller = Controller::build(&settings, edge, Arming::ByItself)?;
        let mut forces = Fnv::default();
        let mut checks = self.checks.iter().peekable();
        for tick in 0..self.ticks.min(MOST_TICKS) {
            let done = controller.tick(&mut patch, script::sensed(tick, LEAD_TICKS), Command::HEARD, true);
            forces.vector(done.applied_n);
            let Some(check) = checks.next_if(|check| check.tick == tick + 1) else { continue };
            let here = [("state", patch.state_hash(), &check.state), ("forces", forces.finish(), &check.forces)];
            for (word, here, board) in here {
                let here = format!("{here:016x}");
                if here != *board {
                    return Ok(Some(Difference { tick: check.tick, word, board: board.clone(), here }));
                }
            }
        }
        // a report that lacks some of the fingerprints, or has them in another order, proves
        // nothing
        Ok(checks.next().map(|check| Difference {
            tick: check.tick,
            word: "order of the fingerprints",
            board: check.state.clone(),
            here: "not met".into(),
        }))
    }

    /// Describes the report, one figure per line.
    pub fn words(&self) -> String {
        let us = |counts: u32| f64::from(counts) / f64::from(self.clock_hz.max(1)) * 1e6;
        let mut text = format!("board   {}, chip {}\n", self.board, self.chip);
        let mut line = |name: &str, words: String| {
            let _ = writeln!(text, "{name:<7} {words}"); // writing to a string does not fail
        };
        let [set, needed] = self.brown_out;
        if set != needed {
            let remedy = format!("`STM32_Programmer_CLI -c port=SWD -ob BOR_LEV={needed}`");
            line("supply", format!("the chip's brown-out level is {set}, set {needed}: {remedy}"));
        }
        line("patch", format!("{} nodes, checksum {}", self.nodes, self.patch_checksum));
        line("clock", format!("{:.1} MHz: {}", f64::from(self.clock_hz) / 1e6, self.clock));
        line("tick", format!("{:.1} us at the longest, {} counts", us(self.worst_tick_counts), self.worst_tick_counts));
        for (stage, counts) in &self.stage_counts {
            line("stage", format!("{stage:<10} {:>7.1} us {counts:>9} counts", us(*counts)));
        }
        line("stack", format!("{} of {} bytes", self.stack_used_bytes, self.stack_bytes));
        let late = format!("{} late, {} missed", self.overruns, self.missed_periods);
        line("run", format!("{} ticks, {late}; mode {}, fault {}", self.ticks, self.mode, self.fault));
        text
    }
}
