//! `palpate board`: commands for a flashed board on its serial port.

mod commission;
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

/// Longest wait for a board: it sends a record every 20 ms, but opening a large patch after
/// power-on takes a second.
const PATIENCE: Duration = Duration::from_secs(2);

#[derive(Args, Clone, Debug)]
pub(super) struct PortArgs {
    /// The board's serial port, such as /dev/ttyACM0 or COM3; `palpate board list` finds it.
    #[arg(long, value_name = "PORT")]
    port: String,
    /// ELF file that was flashed, which explains the board's log [default: the image that `cargo
    /// fw...` built last here, if it is the board's].
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,
}

impl PortArgs {
    /// Opens the port and the board's log.
    fn open(&self) -> Result<(Session, Log), Error> {
        let mut session = Session::open(&self.port, PATIENCE)?;
        let log = Log::of(self.image.as_deref(), &mut session)?;
        Ok((session, log))
    }

    /// Runs a command on the board, and prints the log lines that arrive meanwhile.
    fn with(&self, run: impl FnOnce(&mut Session) -> Result<(), Error>) -> Result<(), Error> {
        let (mut session, mut log) = self.open()?;
        let outcome = run(&mut session);
        log.end(&mut session);
        outcome
    }
}

#[derive(Clone, Debug, Subcommand)]
pub(super) enum BoardCommand {
    /// Find the boards: listen to every USB serial port, and identify every board of ours that
    /// answers.
    ///
    /// Nothing is sent to a port on which no frame of ours arrives. If ports are named, only those
    /// are listened to.
    List {
        /// Ports to listen to [default: all USB serial ports].
        #[arg(value_name = "PORT")]
        ports: Vec<String>,
    },
    /// Compare the report of a self-test image (such as `cargo fw-selftest-f446` builds) with the
    /// same run on this machine: say whether the bits agree, or which word differs.
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
    /// The board arms once the tip has been still outside the tissue for 0.1 s. It ends the force
    /// by itself as soon as it no longer hears this command, for whatever reason. Fails (exit code
    /// 1) if the board ends the force by itself.
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
    /// End the force: request a stop until the board reports that its outputs are off.
    Stop {
        #[command(flatten)]
        port: PortArgs,
    },
    /// Clear a latched fault once its cause is gone. Enables nothing.
    Clear {
        #[command(flatten)]
        port: PortArgs,
    },
    /// Send a patch to an idle board, which keeps it until it loses power.
    Upload {
        /// Patch file of `palpate pack`, `fit`, `plan` or `cut`.
        #[arg(value_name = "PATCH")]
        patch: PathBuf,
        #[command(flatten)]
        port: PortArgs,
    },
    /// Set Young's modulus of the board's patch, between half and twice its own, until the board
    /// loses power.
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
    /// The board restarts with it. A Nucleo does not store profiles yet: it uses this one until it
    /// loses power, and says so.
    Profile {
        /// A device (touch, omni, touch-x, falcon, omega3, inverse3, hapkit, frictionless) or the
        /// path of a profile (.toml, see host-sim/devices).
        #[arg(long, value_name = "NAME|FILE")]
        device: String,
        #[command(flatten)]
        port: PortArgs,
    },
    /// Measure order, sign, unit, friction, mass, delay and lag of a device's axes or joints on an
    /// idle board, with 0.5 N at most, and write them into its profile with the date.
    ///
    /// First you move the handle along each axis by a stated distance, without any force; then you
    /// let it go, and the motors drive it one after the other. Press Enter after each step. Until
    /// the end the profile stays as it was, in the file and on the board: also at Ctrl-C, after a
    /// fault, and if the handle is held or moves.
    Commission(commission::Commission),
    /// Take the present pose of the device as its home pose, on an idle board: for encoders that
    /// count from their position at power-on. A board whose profile asks for a home pose does not
    /// arm without one.
    Home {
        #[command(flatten)]
        port: PortArgs,
    },
    /// Measure the round trip of a message to an idle board.
    Ping {
        #[command(flatten)]
        port: PortArgs,
        /// Number of round trips.
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
            Self::Commission(commission) => commission.run(),
            Self::Home { port } => port.with(transfer::home),
            Self::Ping { port, count } => port.with(|session| transfer::ping(*count, session)),
        }
    }
}
