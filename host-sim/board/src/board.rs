//! The emulator as a board, linked through two FIFOs. The emulator stops while it waits for the
//! host, so nothing here is timed.

use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use palpate_controller::link::frame::FRAME_BYTES;
use palpate_controller::link::{FromBoard, Receiver, ToBoard, encode, upload};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{CWD, FileType, Mode, mknodat};
use tempfile::TempDir;

use super::EmulateError;

/// Longest wait for an answer. An answer needs the emulation of one tick, which takes far less than
/// a millisecond, so a board that is silent for this long has crashed.
const PATIENCE: Duration = Duration::from_secs(20);
/// Longest wait for an answer when every instruction is logged: opening a patch then takes seconds,
/// and half a minute on a busy machine.
const LOGGED_PATIENCE: Duration = Duration::from_secs(200);
/// Longest wait for an image to end by itself.
const FAREWELL: Duration = Duration::from_secs(2);
/// Exponent of the virtual time of an instruction, 2^6 = 64 ns. That is more than a count of the
/// board's clock, so counts resolve single instructions.
pub const SHIFT: u32 = 6;
/// One count of the board's clock [ns].
const NS_PER_COUNT: u64 = 40;

/// An emulated board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum EmulatedBoard {
    /// Cortex-M4F (MPS2 with image AN386).
    #[value(name = "m4f-168", alias = "m4f")]
    M4f,
    /// Cortex-M7 (MPS2 with image AN500).
    #[value(name = "m7-480", alias = "m7")]
    M7,
}

impl EmulatedBoard {
    /// Name on the command line: that of the budget whose patches the board runs.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::M4f => "m4f-168",
            Self::M7 => "m7-480",
        }
    }

    /// The emulator's names of the machine and of its core.
    #[must_use]
    pub fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::M4f => ("mps2-an386", "cortex-m4"),
            Self::M7 => ("mps2-an500", "cortex-m7"),
        }
    }

    /// Clock of the chip that the emulated board represents [Hz].
    #[must_use]
    pub fn clock_hz(self) -> f64 {
        match self {
            Self::M4f => 168e6,
            Self::M7 => 480e6,
        }
    }

    /// Returns a label with the core and the clock to which its estimated times refer.
    #[must_use]
    pub fn timed_on(self) -> &'static str {
        match self {
            Self::M4f => "estimated, M4F at 168 MHz",
            Self::M7 => "estimated, 480 MHz by the M4F's table",
        }
    }
}

/// A running image.
pub struct Board {
    child: Child,
    machine: EmulatedBoard,
    folder: TempDir,
    to: File,
    from: File,
    receiver: Receiver,
    patience: Duration,
    sequence: u16,
    bytes: [u8; 4096],
    read: usize,
    taken: usize,
}

/// Number of instructions in a span of the board's clock, exact to one.
#[must_use]
pub fn instructions(counts: u32) -> u64 {
    (u64::from(counts) * NS_PER_COUNT) >> SHIFT
}

impl Board {
    /// Starts an image without waiting.
    ///
    /// # Errors
    /// There is no emulator, or the FIFOs cannot be made.
    pub fn start(image: &Path, machine: EmulatedBoard, log: Option<&Path>) -> Result<Self, EmulateError> {
        let folder = tempfile::tempdir()?;
        let [to_path, from_path] = ["to", "from"].map(|name| folder.path().join(name));
        for path in [&to_path, &from_path] {
            mknodat(CWD, path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).map_err(std::io::Error::from)?;
        }
        // opened for reading and writing, since opening one end of a FIFO alone would block until
        // the other is opened
        let open = |path: &Path| OpenOptions::new().read(true).write(true).open(path);
        let (to, from) = (open(&to_path)?, open(&from_path)?);
        let words = File::create(folder.path().join("words"))?;
        let (name, cpu) = machine.names();
        let mut command = Command::new("qemu-system-arm");
        command.args(["-machine", name, "-cpu", cpu, "-nographic", "-monitor", "none", "-serial", "null"]);
        let link = [&to_path, &from_path].map(|path| path.display().to_string());
        let arguments = format!("enable=on,target=native,arg=palpate-firmware,arg=lock-step,arg={},arg={}", link[0], link[1]);
        command.args(["-semihosting-config", &arguments, "-icount", &format!("shift={SHIFT},sleep=off")]);
        if let Some(log) = log {
            command.args(["-singlestep", "-d", "exec,nochain", "-D"]).arg(log);
        }
        command.arg("-kernel").arg(image).stdin(Stdio::null()).stdout(Stdio::null()).stderr(words);
        let child = command.spawn().map_err(|source| EmulateError::NotStarted { program: "qemu-system-arm", source })?;
        let patience = if log.is_some() { LOGGED_PATIENCE } else { PATIENCE };
        Ok(Self {
            child,
            machine,
            folder,
            to,
            from,
            receiver: Receiver::NEW,
            patience,
            sequence: 0,
            bytes: [0; 4096],
            read: 0,
            taken: 0,
        })
    }

    /// The kind of board that is emulated.
    #[must_use]
    pub fn machine(&self) -> EmulatedBoard {
        self.machine
    }

    /// Sends a message.
    ///
    /// # Errors
    /// The FIFO is gone.
    pub fn send(&mut self, message: &ToBoard<'_>) -> Result<(), EmulateError> {
        let mut out = [0; FRAME_BYTES];
        let frame = encode(self.sequence, message, &mut out)?;
        self.sequence = self.sequence.wrapping_add(1);
        self.send_bytes(frame)
    }

    /// Sends bytes unchanged, valid frames or not.
    ///
    /// # Errors
    /// The FIFO is gone.
    pub fn send_bytes(&mut self, bytes: &[u8]) -> Result<(), EmulateError> {
        Ok(self.to.write_all(bytes)?)
    }

    /// The board's next message.
    ///
    /// # Errors
    /// The board has crashed, or a frame arrived damaged.
    pub fn receive(&mut self) -> Result<FromBoard, EmulateError> {
        loop {
            while self.taken < self.read {
                let byte = self.bytes[self.taken];
                self.taken += 1;
                if let Some(message) = self.receiver.push(byte) {
                    return Ok(message?);
                }
            }
            self.wait()?;
            self.read = self.from.read(&mut self.bytes)?;
            self.taken = 0;
        }
    }

    /// Reads the answer to a change of Young's modulus under force.
    ///
    /// # Errors
    /// [`EmulateError::Refused`] gives the board's reason.
    pub fn modulus_taken(&mut self) -> Result<(), EmulateError> {
        match self.receive()? {
            FromBoard::Modulus(_) => Ok(()),
            FromBoard::Refused(refusal) => Err(EmulateError::Refused(refusal)),
            other => Err(EmulateError::OutOfTurn(format!("{other:?}"))),
        }
    }

    /// Waits until there is something to read.
    fn wait(&mut self) -> Result<(), EmulateError> {
        let begun = Instant::now();
        loop {
            let mut fds = [PollFd::new(&self.from, PollFlags::IN)];
            let step = Timespec { tv_sec: 0, tv_nsec: 100_000_000 };
            if poll(&mut fds, Some(&step)).map_err(std::io::Error::from)? > 0 {
                return Ok(());
            }
            if self.child.try_wait()?.is_some() || begun.elapsed() > self.patience {
                return Err(EmulateError::Silent(self.last_words()));
            }
        }
    }

    /// Returns the lines that the image printed, joined by semicolons.
    #[must_use]
    pub fn last_words(&self) -> String {
        let text = std::fs::read(self.folder.path().join("words")).unwrap_or_default();
        // without the registers that the emulator prints below them
        let lines: Vec<_> =
            String::from_utf8_lossy(&text).lines().take_while(|line| !line.is_empty()).map(str::to_owned).collect();
        lines.join("; ")
    }

    /// Sends a patch to the board, which has to be idle, and returns the number of its nodes.
    ///
    /// # Errors
    /// [`EmulateError::Refused`] gives the board's reason.
    pub fn upload(&mut self, patch: &[u8]) -> Result<u32, EmulateError> {
        upload::messages(patch).try_for_each(|message| self.send(&message))?;
        match self.receive()? {
            FromBoard::PatchTaken(nodes) => Ok(nodes),
            FromBoard::Refused(refusal) => Err(EmulateError::Refused(refusal)),
            other => Err(EmulateError::OutOfTurn(format!("{other:?}"))),
        }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        // without a host the image ends by itself, and its log is complete
        if let (Ok(to), Ok(from)) = (File::open("/dev/null"), File::open("/dev/null")) {
            (self.to, self.from) = (to, from);
        }
        let begun = Instant::now();
        while begun.elapsed() < FAREWELL {
            if !matches!(self.child.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        // kills only the process that was started here
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
