//! The image runs at the pace of its own tick timer and is pressed by its scripted hand. This shows
//! when ticks start, and what happens when they take too long.
//!
//! Every instruction takes 2^shift ns of virtual time, so a larger shift means a slower core.
//! **Emulated counts, not hardware time.**
//!
//! * in: an image, which presses the patch that is built into it
//! * out: delay of the start of a tick after the timer's edge, late ticks, the reason why the
//!   outputs were turned off, and the log
//! * fails if the image does not end

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde::Serialize;

use super::{EmulateError, EmulatedBoard, defmt_log};

/// Shift at which a tick fits into its period, and the clock resolves five instructions.
pub const IN_TIME_SHIFT: u32 = 3;
/// Shifts for slower and slower cores.
const SLOW_SHIFTS: [u32; 5] = [4, 5, 6, 7, 8];
/// Ticks of a run on a slow core: the force is on after 700 ticks, and one of the first three ticks
/// is late.
const SLOW_TICKS: u32 = 1_000;
/// Time limit of a run, which takes seconds: a run that hangs must not block the caller.
const PATIENCE: Duration = Duration::from_secs(120);

/// Results of a timed run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Timed {
    /// Exponent of the virtual time of an instruction, which is 2^shift ns.
    pub shift: u32,
    /// Shortest and longest delay from the timer's edge to the start of a tick [instructions].
    pub start_instructions: Option<[f64; 2]>,
    /// Longest completed tick, relative to the period (1).
    pub longest_over_period: Option<f64>,
    /// Number of ticks that ran.
    pub ticks: Option<u64>,
    /// Ticks that ended after their period.
    pub late_ticks: Option<u64>,
    /// Periods that passed during late ticks, as counted by the loop.
    pub missed_periods: Option<u64>,
    /// Timer periods in excess of the ticks: those that passed during a tick, counted outside the
    /// loop.
    pub periods_without_tick: Option<u64>,
    /// Mode and fault at the end of the run.
    pub ended: String,
    /// Time from the last completed tick to the watchdog's reset [us], if it occurred.
    pub watchdog_us: Option<u64>,
    /// Log of the image, one message per line.
    #[serde(skip)]
    pub log: String,
}

impl Timed {
    /// Periods without a tick that the loop did not count; there must be none.
    #[must_use]
    pub fn uncounted(&self) -> Option<u64> {
        self.periods_without_tick.zip(self.missed_periods).map(|(seen, counted)| seen.abs_diff(counted))
    }
}

/// Runs an image for this many ticks.
///
/// # Errors
/// There is no emulator, or the image does not end.
pub fn run(image: &Path, machine: EmulatedBoard, shift: u32, ticks: u32) -> Result<Timed, EmulateError> {
    let Printed { text, frames } = printed(image, machine, shift, ticks)?;
    let number = |key| value(&text, key).and_then(|word| word.parse::<u64>().ok());
    let instructions = |ns: u64| ns as f64 / f64::from(1_u32 << shift);
    let starts = number("earliest_start_ns").zip(number("latest_start_ns"));
    let ended = text.lines().find(|line| line.starts_with("mode=") || line.starts_with("watchdog")).unwrap_or("no result");
    let (periods, ran) = (number("periods"), number("ticks"));
    Ok(Timed {
        shift,
        start_instructions: starts.map(|(first, last)| [instructions(first), instructions(last)]),
        longest_over_period: number("longest_tick_ns").map(|ns| ns as f64 * 1e-6),
        ticks: ran,
        late_ticks: number("overruns"),
        missed_periods: number("missed_periods"),
        periods_without_tick: periods.zip(ran).map(|(began, ran)| began.saturating_sub(ran)),
        ended: ended.into(),
        watchdog_us: number("silent_us"),
        log: defmt_log::decode(&std::fs::read(image)?, &frames),
    })
}

/// Runs the image on slower and slower cores, up to ticks of some twenty periods.
///
/// # Errors
/// Errors of [`run`].
pub fn overruns(image: &Path, machine: EmulatedBoard) -> Result<Vec<Timed>, EmulateError> {
    SLOW_SHIFTS.into_iter().map(|shift| run(image, machine, shift, SLOW_TICKS)).collect()
}

/// Output of an image: printed text, and frames of its log.
struct Printed {
    text: String,
    /// Encoded defmt frames, in the order of arrival.
    frames: Vec<u8>,
}

fn printed(image: &Path, machine: EmulatedBoard, shift: u32, ticks: u32) -> Result<Printed, EmulateError> {
    let folder = tempfile::tempdir()?;
    let [words, frames] = ["words", "frames"].map(|name| folder.path().join(name));
    let (name, cpu) = machine.names();
    let mut child = Command::new("qemu-system-arm")
        .args(["-machine", name, "-cpu", cpu, "-nographic", "-monitor", "none", "-serial", "null"])
        .args(["-semihosting-config", &format!("enable=on,target=native,arg=palpate-firmware,arg={ticks}")])
        .args(["-icount", &format!("shift={shift},sleep=off"), "-kernel"])
        .arg(image)
        .stdin(Stdio::null())
        .stdout(std::fs::File::create(&frames)?)
        .stderr(std::fs::File::create(&words)?)
        .spawn()
        .map_err(|source| EmulateError::NotStarted { program: "qemu-system-arm", source })?;
    let begun = Instant::now();
    while child.try_wait()?.is_none() {
        if begun.elapsed() > PATIENCE {
            // kills only the process that was started here
            child.kill()?;
            child.wait()?;
            return Err(EmulateError::Silent(std::fs::read_to_string(&words).unwrap_or_default()));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(Printed { text: std::fs::read_to_string(&words)?, frames: std::fs::read(&frames)? })
}

/// The word after `key=`; the last one if there are several.
fn value<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let pairs = text.split_whitespace().rev().filter_map(|word| word.split_once('='));
    pairs.into_iter().find_map(|(name, value)| (name == key).then_some(value))
}

#[cfg(test)]
mod tests {
    use super::value;

    #[test]
    fn numbers_are_found_by_their_key() {
        let text = "periods=12 missed_periods=3\nwatchdog: no tick was completed for silent_us=4500\noutputs off\n";
        assert_eq!(["periods", "missed_periods", "silent_us"].map(|key| value(text, key)), [Some("12"), Some("3"), Some("4500")]);
        assert_eq!(value(text, "ticks"), None);
    }
}
