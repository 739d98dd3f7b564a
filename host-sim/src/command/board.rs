//! `palpate board`: commands for a flashed board on its serial port.

mod commission;
mod hold;
mod list;
mod log;
mod self_test;
mod status;
mod transfer;

use std::time::Duration;

use self::log::Log;
use super::options::board::{BoardCommand, PortArgs};
use crate::error::Error;
use crate::port::Session;

/// Longest wait for a board: it sends a record every 20 ms, but opening a large patch after
/// power-on takes a second.
const PATIENCE: Duration = Duration::from_secs(2);

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
