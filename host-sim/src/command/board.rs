//! `palpate board`: a flashed board on its serial port.

mod hold;
mod list;
mod log;
mod self_test;
mod status;
mod transfer;

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Subcommand};

use self::log::Log;
use crate::error::Error;
use crate::port::Session;

/// A board of ours sends a record every 20 ms; opening a large patch after power-on takes it a
/// second.
const PATIENCE: Duration = Duration::from_secs(2);

#[derive(Args, Clone, Debug)]
pub(super) struct PortArgs {
    /// The board's serial port, such as /dev/ttyACM0 or COM3; `palpate board list` finds it.
    #[arg(long, value_name = "PORT")]
    port: String,
    /// The ELF file that was flashed, which explains the board's log [default: the image that
    /// `cargo fw...` built last here, if it is the board's].
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,
}

impl PortArgs {
    /// Opens the port.
    fn open(&self) -> Result<(Session, Log), Error> {
        let mut session = Session::open(&self.port, PATIENCE)?;
        let log = Log::of(self.image.as_deref(), &mut session)?;
        Ok((session, log))
    }

    /// Runs a command on the board, and prints the log that comes meanwhile.
    fn with(&self, run: impl FnOnce(&mut Session) -> Result<(), Error>) -> Result<(), Error> {
        let (mut session, mut log) = self.open()?;
        let outcome = run(&mut session);
        log.end(&mut session);
        outcome
    }
}

#[derive(Clone, Debug, Subcommand)]
pub(super) enum BoardCommand {
    /// Find the boards: every USB serial port is listened to, and whoever speaks our frames is
    /// asked who it is.
    ///
    /// Nothing is sent to a port that does not speak them. Ports that are named are listened to in
    /// place of the system's.
    List {
        /// Ports to listen to [default: all USB serial ports].
        #[arg(value_name = "PORT")]
        ports: Vec<String>,
    },
    /// Compare the report of a self-test image (`cargo fw-selftest-f446` and its sisters) with the
    /// same run on this machine: same bits, or which word differs.
    ///
    /// Nothing is sent. Fails (exit code 1) if the bits differ or the board's run did not pass.
    SelfTest(self_test::SelfTest),
    /// Show image, mode, fault, force, patch, time of a tick, stack and log of a board. Changes
    /// nothing.
    Status {
        #[command(flatten)]
        port: PortArgs,
    },
    /// Enable the force and hold it until Ctrl-C, then stop.
    ///
    /// The board arms once the tip has been still outside the tissue for 0.1 s. It takes the force
    /// away by itself as soon as it does not hear this command any more, however that came about.
    /// Fails (exit code 1) if the board ends the force by itself.
    Arm {
        #[command(flatten)]
        port: PortArgs,
        #[command(flatten)]
        stream: hold::Stream,
    },
    /// Stream a board's records without enabling anything, until Ctrl-C.
    Watch {
        #[command(flatten)]
        port: PortArgs,
        #[command(flatten)]
        stream: hold::Stream,
    },
    /// End the force: ask for a stop until the board says that its outputs are off.
    Stop {
        #[command(flatten)]
        port: PortArgs,
    },
    /// Clear a latched fault, when its cause is gone. Enables nothing.
    Clear {
        #[command(flatten)]
        port: PortArgs,
    },
    /// Send a patch to an idle board. It is forgotten with the power.
    Upload {
        /// Patch file of `palpate pack`, `fit`, `plan` or `cut`.
        #[arg(value_name = "PATCH")]
        patch: PathBuf,
        #[command(flatten)]
        port: PortArgs,
    },
    /// Set Young's modulus of the board's patch, between half and twice its own. It is forgotten
    /// with the power.
    Modulus {
        /// Young's modulus [Pa].
        #[arg(value_name = "PA", allow_negative_numbers = true)]
        pascal: f32,
        #[command(flatten)]
        port: PortArgs,
    },
    /// Give an idle board the profile of a device: its limits, workspace, encoders and mechanism,
    /// kept without power.
    ///
    /// The board starts up anew with it. A Nucleo keeps none yet, uses it until its power goes, and
    /// says so.
    Profile {
        /// A device (touch, omni, touch-x, falcon, omega3, inverse3, hapkit, frictionless) or the
        /// path of a profile (.toml, see host-sim/devices).
        #[arg(long, value_name = "NAME|FILE")]
        device: String,
        #[command(flatten)]
        port: PortArgs,
    },
    /// Take the pose of the device as its home pose, on an idle board: for encoders that count from
    /// where they were at power-on. A board whose profile asks for a home pose does not arm before
    /// it has one.
    Home {
        #[command(flatten)]
        port: PortArgs,
    },
    /// Measure the round trip of a message to an idle board.
    Ping {
        #[command(flatten)]
        port: PortArgs,
        /// Round trips.
        #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
        count: u32,
    },
}

impl BoardCommand {
    pub(super) fn run(&self) -> Result<(), Error> {
        match self {
            Self::List { ports } => list::run(ports),
            Self::SelfTest(test) => test.run(),
            Self::Status { port } => status::run(port),
            Self::Arm { port, stream } => hold::arm(port, stream),
            Self::Watch { port, stream } => hold::watch(port, stream),
            Self::Stop { port } => port.with(hold::stop),
            Self::Clear { port } => port.with(hold::clear),
            Self::Upload { patch, port } => transfer::upload(patch, port),
            Self::Modulus { pascal, port } => port.with(|session| transfer::modulus(*pascal, session)),
            Self::Profile { device, port } => transfer::profile(device, port),
            Self::Home { port } => port.with(transfer::home),
            Self::Ping { port, count } => port.with(|session| transfer::ping(*count, session)),
        }
    }
}
