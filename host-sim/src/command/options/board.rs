//! Command line of `palpate board`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::command::length::metres;
use crate::error::Error;

#[derive(Args, Clone, Debug)]
pub struct PortArgs {
    /// The board's serial port, such as /dev/ttyACM0 or COM3; `palpate board list` finds it.
    #[arg(long, value_name = "PORT")]
    pub port: String,
    /// ELF file that was flashed, which explains the board's log [default: the image that `cargo
    /// fw...` built last here, if it is the board's].
    #[arg(long, value_name = "ELF")]
    pub image: Option<PathBuf>,
}

#[derive(Clone, Debug, Subcommand)]
pub enum BoardCommand {
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
    SelfTest(SelfTest),
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
        stream: Stream,
    },
    /// Stream a board's records without enabling anything, until Ctrl-C.
    Watch {
        #[command(flatten)]
        port: PortArgs,
        #[command(flatten)]
        stream: Stream,
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
        /// Patch file of `palpate pack` or `fit`.
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
    /// The board restarts with it.
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
    Commission(Commission),
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

#[derive(Args, Clone, Debug)]
pub struct Commission {
    #[command(flatten)]
    pub port: PortArgs,
    /// Profile of the device (.toml), or the name of one that ships.
    #[arg(long, value_name = "NAME|FILE")]
    pub device: String,
    /// Distance by which you move the handle along each axis.
    #[arg(long, value_name = "LENGTH", default_value = "50mm", value_parser = metres)]
    pub distance: f64,
    /// File to write the measured profile to [default: the file of --device].
    #[arg(long, value_name = "FILE.toml")]
    pub out: Option<PathBuf>,
}

#[derive(Args, Clone, Debug)]
pub struct Stream {
    /// Seconds after which to end [default: at Ctrl-C].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    /// Also write the records, 500 per second, to a CSV file, which appears when the command is
    /// done, but not if the port is lost.
    #[arg(long, value_name = "FILE.csv")]
    pub out: Option<PathBuf>,
    /// Also write the records to this CSV file as they arrive, for `palpate live --follow` or
    /// another reader. An earlier file is replaced, and the rows are kept however the command ends.
    #[arg(long, value_name = "FILE.csv")]
    pub stream: Option<PathBuf>,
}

#[derive(Args, Clone, Debug)]
pub struct SelfTest {
    /// The board's serial port.
    #[arg(long, value_name = "PORT", required_unless_present = "report", conflicts_with = "report")]
    pub port: Option<String>,
    /// A stored report in place of a port: the board's line, with or without other text.
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// The patch that was built into the image [default: the one that ships with its checksum].
    #[arg(long, value_name = "FILE")]
    pub patch: Option<PathBuf>,
    /// Also write the report to this file, to send it to someone.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

impl BoardCommand {
    /// Checks nothing: whatever can be wrong is known to the port.
    pub fn check(&self) -> Result<(), Error> {
        Ok(())
    }
}
