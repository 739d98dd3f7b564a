//! Builds the firmware and runs it in the emulator.

use core::time::Duration;
use std::{
    io::{self, Read},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::{Mutex, PoisonError},
    thread,
    time::Instant,
};

use palpate_board::EmulatedBoard;
use palpate_board::defmt_log;
use palpate_board::firmware_image::FirmwareImage;

use crate::crash::{self, Planned};
use crate::debugger::Debugger;
use crate::packed;

/// Time limit of a run. Runs take seconds; one that hangs must not hang the tests.
const TIMEOUT: Duration = Duration::from_secs(300);

/// Items of the emulator's log: one line before each executed instruction (with `-singlestep`).
const LOGGED: &str = "exec,nochain";

/// Function that begins each period.
const PERIOD: &str = "palpate_firmware::board::mps2::on_tick_timer";

/// Target of the boards, as in `cargo fw`.
const TARGET: &str = "thumbv7em-none-eabihf";

/// Reason why a run has no outcome.
#[derive(Debug, thiserror::Error)]
pub enum EmulatorError {
    /// A program could not be started.
    #[error("{program}: {source}; install it (Debian: qemu-system-arm)")]
    NotStarted {
        /// Name of the program.
        program: String,
        /// Error from the operating system.
        source: io::Error,
    },
    /// The firmware does not compile.
    #[error("the firmware was not built: {0}")]
    NotBuilt(String),
    /// The debugger failed to plant the crash or to begin the log.
    #[error("the debugger could not make the crash or begin the log: {source}; the firmware's last words: {last_words}")]
    Debugger {
        /// Error of the connection.
        source: io::Error,
        /// Text that the firmware had printed until then.
        last_words: String,
    },
    /// The run exceeded the time limit and was killed.
    #[error("the firmware was still running after {} s; its last words: {last_words}", TIMEOUT.as_secs())]
    TimedOut {
        /// Text that the firmware had printed until then.
        last_words: String,
    },
    /// A run ended without printing its result.
    #[error("the firmware printed no result; its last words: {0}")]
    NoResult(String),
}

/// Settings of a run.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// Board to emulate.
    pub machine: EmulatedBoard,
    /// Virtual time per instruction: 2^shift ns.
    pub shift: u32,
    /// Number of ticks after which the firmware stops.
    pub ticks: u32,
    /// Ticks that the scripted hand waits outside the tissue. A force is allowed after some 600
    /// ticks; the patch itself runs from the third tick on.
    pub lead_ticks: u32,
    /// Crash that a debugger plants.
    pub crash: Option<Planned>,
    /// Whether the board resets after a crash, as on hardware; otherwise the run ends.
    pub restart: bool,
    /// File that receives a log of every executed instruction from the first period on, or from the
    /// planted crash. A log slows the emulator down a hundredfold, and opening the patch takes more
    /// instructions than a hundred ticks.
    pub exec_log: Option<&'a Path>,
}

/// Exit status and output of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Exit status of the firmware.
    pub exit_status: Option<i32>,
    /// Plain text, from semihosting's standard error.
    pub text: String,
    /// defmt frames, undecoded.
    pub frames: Vec<u8>,
}

/// The line with which a run ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunResult {
    /// Hash of the last state.
    pub state_hash: u64,
    /// Hash of the forces of all ticks.
    pub force_hash: u64,
    /// Number of ticks run.
    pub ticks: u32,
    /// Number of ticks that ended after their deadline.
    pub overruns: u32,
    /// Number of ticks in the mode `Fault`.
    pub faults: u32,
}

/// Builds the firmware with its default patch and returns its ELF file. `target` is cargo's target
/// directory.
pub fn build_firmware(target: &Path, features: &[&str]) -> Result<PathBuf, EmulatorError> {
    if features.is_empty() { build(target, &[], None, "palpate-firmware") } else { variant(target, features, None) }
}

/// Builds the firmware with the patch file `patch`, an absolute path, and returns its ELF file.
/// `target` is cargo's target directory.
pub fn build_firmware_with(target: &Path, features: &[&str], patch: &Path) -> Result<PathBuf, EmulatorError> {
    if patch == packed::shipped("block-m4f-168.patch") {
        return build_firmware(target, features); // it is the default one
    }
    variant(target, features, Some(patch))
}

/// Builds an image whose own code has overflow checks and debug assertions. It is never flashed.
pub fn build_checked_firmware(target: &Path) -> Result<PathBuf, EmulatorError> {
    let mut command = image_at(&target.join("checked"), Some(target), &[], None, "palpate-firmware");
    for package in ["palpate", "palpate-controller", "palpate-firmware"] {
        for check in ["overflow-checks", "debug-assertions"] {
            command.args(["--config", &format!("profile.firmware.package.{package}.{check}=true")]);
        }
    }
    built(command, target.join("checked").join(TARGET).join("firmware/palpate-firmware"))
}

/// Builds the image of a real board with the patch of its alias `fw-BOARD`. `./test` has built the
/// same one with the same command beside the lints.
pub fn build_flashed(target: &Path, board: &str) -> Result<PathBuf, EmulatorError> {
    static BUILDING: Mutex<()> = Mutex::new(());
    let _one_at_a_time = BUILDING.lock().unwrap_or_else(PoisonError::into_inner);
    let own = target.join("flashed").join(board);
    let mut command = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".into()));
    command.args([&format!("fw-{board}"), "--bin", "palpate-firmware", "--target-dir"]).arg(&own);
    command.env_remove("PALPATE_PATCH").env("CARGO_BUILD_BUILD_DIR", target);
    let triple = if board.ends_with("pico2") { "thumbv8m.main-none-eabihf" } else { TARGET };
    built(command, own.join(triple).join("firmware/palpate-firmware"))
}

/// Links an image that contains a tick and no code that may panic. With `planted` it contains one
/// panic and must not link. Uses the libraries of the default image.
pub fn link_panic_proof(target: &Path, planted: bool) -> Result<PathBuf, EmulatorError> {
    let features = if planted { &["panic-proof-bites"][..] } else { &["panic-proof"] };
    build(target, features, None, "panic-proof")
}

/// Builds an image that must not be flashed by mistake. All such images are linked below
/// `target/variants` with the same libraries, one at a time, and then copied to a file named after
/// their features and their patch.
fn variant(target: &Path, features: &[&str], patch: Option<&Path>) -> Result<PathBuf, EmulatorError> {
    static BUILDING: Mutex<()> = Mutex::new(());
    let _one_at_a_time = BUILDING.lock().unwrap_or_else(PoisonError::into_inner);
    let libraries = target;
    let target = target.join("variants");
    let own = [&["variant"], features].concat();
    let elf = build_with(&target, Some(libraries), &own, patch, "palpate-firmware")?;
    let patch = patch.and_then(Path::file_stem).map(|stem| stem.display().to_string());
    let named = target.join(features.iter().copied().map(str::to_owned).chain(patch).collect::<Vec<_>>().join("-") + ".elf");
    std::fs::copy(&elf, &named).map_err(|cause| EmulatorError::NotBuilt(format!("{}: {cause}", named.display())))?;
    Ok(named)
}

fn build(target: &Path, features: &[&str], patch: Option<&Path>, image: &str) -> Result<PathBuf, EmulatorError> {
    build_with(target, None, features, patch, image)
}

/// Builds an image below `target`. Its libraries are kept there too, unless another target
/// directory is given.
fn build_with(
    target: &Path,
    libraries: Option<&Path>,
    features: &[&str],
    patch: Option<&Path>,
    image: &str,
) -> Result<PathBuf, EmulatorError> {
    built(image_at(target, libraries, features, patch, image), target.join(TARGET).join("firmware").join(image))
}

/// Command that builds the image.
fn image_at(target: &Path, libraries: Option<&Path>, features: &[&str], patch: Option<&Path>, image: &str) -> Command {
    let mut command = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".into()));
    match patch {
        Some(patch) => command.env("PALPATE_PATCH", patch),
        None => command.env_remove("PALPATE_PATCH"),
    };
    if let Some(libraries) = libraries {
        command.env("CARGO_BUILD_BUILD_DIR", libraries);
    }
    command
        .args(["build", "--package", "palpate-firmware", "--profile", "firmware", "--target", TARGET])
        .args(["--bin", image, "--features", &[&["mps2"], features].concat().join(","), "--target-dir"])
        .arg(target);
    command
}

/// Runs cargo in the repository and returns the path of the image that it has built.
fn built(mut command: Command, image: PathBuf) -> Result<PathBuf, EmulatorError> {
    let output = command
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .output()
        .map_err(|source| EmulatorError::NotStarted { program: command.get_program().to_string_lossy().into_owned(), source })?;
    if output.status.success() {
        Ok(image)
    } else {
        Err(EmulatorError::NotBuilt(String::from_utf8_lossy(&output.stderr).into_owned()))
    }
}

impl Run<'_> {
    fn command(&self, elf: &Path, socket: &Path) -> Command {
        let (machine, cpu) = self.machine.names();
        let mut command = Command::new("qemu-system-arm");
        command.args(["-machine", machine, "-cpu", cpu, "-nographic", "-monitor", "none", "-serial", "null"]);
        let restart = if self.restart { ",arg=restart" } else { "" };
        if self.is_debugged() {
            command.arg("-S").arg("-gdb").arg(format!("unix:{},server=on,wait=off", socket.display()));
        }
        command.arg("-semihosting-config");
        command.arg(format!("enable=on,target=native,arg=palpate-firmware,arg={},arg={}{restart}", self.ticks, self.lead_ticks));
        // without `sleep` the emulator's clock jumps when a debugger stops it; a scripted run never
        // sleeps
        let sleep = if self.is_debugged() { "on" } else { "off" };
        command.arg("-icount").arg(format!("shift={},sleep={sleep}", self.shift));
        if let Some(log) = self.exec_log {
            command.args(["-singlestep", "-D"]).arg(log);
        }
        if self.exec_log.is_some()
            && self.crash.is_none()
            && let Some(ranges) = but_idling(elf)
        {
            command.arg("-dfilter").arg(ranges);
        }
        command.arg("-kernel").arg(elf);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn is_debugged(&self) -> bool {
        self.crash.is_some() || self.exec_log.is_some()
    }

    /// Plants the crash, and begins the log when it happens or at the first period.
    fn debug(&self, mut debugger: Debugger, image: &FirmwareImage) -> io::Result<()> {
        if let Some(planned) = &self.crash {
            crash::plant(&mut debugger, image, planned)?;
        }
        if self.exec_log.is_some() {
            let period = image.function_named(PERIOD).ok_or_else(|| io::Error::other("the image has no tick timer"))?;
            debugger.run_to(if self.crash.is_some() { crash::CRASH } else { period.address })?;
            debugger.monitor(&format!("log {LOGGED}"))?;
        }
        debugger.detach()
    }

    /// Runs an image until it exits.
    pub fn start(&self, elf: &Path) -> Result<Outcome, EmulatorError> {
        let not_started = |source| EmulatorError::NotStarted { program: "qemu-system-arm".into(), source };
        let folder = tempfile::tempdir().map_err(not_started)?;
        let socket = folder.path().join("debugger");
        let mut child = self.command(elf, &socket).spawn().map_err(not_started)?;
        let (frames, text) = (drain(child.stdout.take()), drain(child.stderr.take()));
        if self.is_debugged() {
            let image = std::fs::read(elf).map_err(not_started)?;
            let image = FirmwareImage::parse(&image).map_err(|cause| EmulatorError::NotBuilt(cause.to_string()))?;
            if let Err(source) = Debugger::connect(&socket).and_then(|debugger| self.debug(debugger, &image)) {
                child.kill().map_err(not_started)?;
                child.wait().map_err(not_started)?;
                let last_words = String::from_utf8_lossy(&text.join().unwrap_or_default()).into_owned();
                return Err(EmulatorError::Debugger { source, last_words });
            }
        }
        let begun = Instant::now();
        let status = loop {
            match child.try_wait().map_err(not_started)? {
                Some(status) => break Some(status),
                None if begun.elapsed() > TIMEOUT => {
                    child.kill().map_err(not_started)?;
                    child.wait().map_err(not_started)?;
                    break None;
                }
                None => thread::sleep(Duration::from_millis(5)),
            }
        };
        let frames = frames.join().unwrap_or_default();
        let text = String::from_utf8_lossy(&text.join().unwrap_or_default()).into_owned();
        match status {
            Some(status) => Ok(Outcome { exit_status: status.code(), text, frames }),
            None => Err(EmulatorError::TimedOut { last_words: text }),
        }
    }
}

/// Address ranges of a log without the loop that waits for interrupts, which makes up half of the
/// executed instructions and is of no interest.
fn but_idling(elf: &Path) -> Option<String> {
    let image = FirmwareImage::parse(&std::fs::read(elf).ok()?).ok()?;
    let main = image.function_named("palpate_firmware::__cortex_m_rt_main")?;
    let end = main.address + main.bytes;
    Some(format!("0+{:#x},{end:#x}+{:#x}", main.address, u32::MAX / 2 - end))
}

fn drain(pipe: Option<impl Read + Send + 'static>) -> thread::JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            // a broken pipe ends the text, but the text before it is still useful
            let _ = pipe.read_to_end(&mut bytes);
        }
        bytes
    })
}

impl Outcome {
    /// The number after `key=` in the plain text; the last one if there are several.
    pub fn number(&self, key: &str) -> Option<u64> {
        value(&self.text, key)?.parse().ok()
    }

    /// The line with which the run ended, from the plain text, which needs no decoder.
    pub fn result(&self) -> Result<RunResult, EmulatorError> {
        RunResult::parse(&self.text).ok_or_else(|| EmulatorError::NoResult(self.text.clone()))
    }

    /// Decoded defmt messages.
    pub fn messages(&self, elf: &[u8]) -> String {
        defmt_log::decode(elf, &self.frames)
    }
}

impl RunResult {
    /// Parses the last line of this form in a text.
    pub fn parse(text: &str) -> Option<Self> {
        let line = text.lines().rfind(|line| line.contains("state_hash="))?;
        let hash = |key| u64::from_str_radix(value(line, key)?, 16).ok();
        let number = |key| value(line, key)?.parse().ok();
        Some(Self {
            state_hash: hash("state_hash")?,
            force_hash: hash("force_hash")?,
            ticks: number("ticks")?,
            overruns: number("overruns")?,
            faults: number("faults")?,
        })
    }
}

fn value<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let mut words = text.split_whitespace().rev();
    words.find_map(|word| word.split_once('=').filter(|(name, _)| *name == key).map(|(_, value)| value))
}

#[cfg(test)]
mod tests {
    use super::RunResult;

    #[test]
    fn the_result_line_is_found_among_others() {
        let text =
            "longest_tick_ns=84560\nstate_hash=00000000000000ff force_hash=0000000000000010 ticks=3 overruns=1 faults=0\nbye\n";
        let expected = RunResult { state_hash: 255, force_hash: 16, ticks: 3, overruns: 1, faults: 0 };
        assert_eq!(RunResult::parse(text), Some(expected));
        assert_eq!(RunResult::parse("ticks=3\n"), None);
    }
}
