//! A session with a board: it finds and identifies the board, keeps its force on, and releases it.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use palpate::haptic::cycle::ArmingSettings;
use palpate::haptic::mode::Mode;
use palpate_controller::board::About;
use palpate_controller::link::message::HostAsk;
use palpate_controller::link::receiver::Counts;
use palpate_controller::link::{FromBoard, Identity, Log, Record, ToBoard};

use super::line::Gone;
use super::{Line, PortError};

/// Time between two keep-alive messages: a quarter of the board's timeout.
const HEARTBEAT: Duration = Duration::from_millis(5);
/// Longest silence of a board, which sends 500 records per second without a request.
pub const SILENCE: Duration = Duration::from_secs(2);
/// Time between two attempts of a request.
const AGAIN: Duration = Duration::from_millis(50);
/// Longest wait for an answer: a board that heard another host accepts a new one after 100 ticks.
const ANSWER: Duration = Duration::from_millis(1_500);
/// Longest wait for a stop: the force ramps down in 0.12 s, and a busy machine may need the rest.
const STOPPED: Duration = Duration::from_secs(2);

/// A Palpate board on a port.
pub struct Session {
    line: Line,
    /// Image, clock and patch of the board.
    pub identity: Identity,
    /// The newest record of the board.
    pub record: Record,
    /// Pieces of the log that were not read yet.
    pub log: Vec<Log>,
    heard: Instant,
    /// Longest silence that is no loss: longer while the board restarts to store a profile.
    pub silence: Duration,
    /// Whether keep-alive messages are sent while nothing else is sent.
    pub keep_alive: bool,
}

impl Session {
    /// Opens a port and waits up to `patience` for a frame of a Palpate board. Nothing is sent
    /// before one arrives, so that other devices are not disturbed. Then the board is asked for its
    /// identification, which changes nothing.
    pub fn open(port: &str, patience: Duration) -> Result<Self, PortError> {
        let mut line = Line::open(port)?;
        let begun = Instant::now();
        let mut log = Vec::new();
        let record = loop {
            match line.receive(patience.saturating_sub(begun.elapsed())) {
                Ok(Some(FromBoard::Record(record))) => break record,
                Ok(Some(FromBoard::Log(piece))) => log.push(piece),
                Ok(Some(_)) => {}
                Ok(None) if line.heard_bytes() == 0 => return Err(PortError::Mute(port.into())),
                Ok(None) => return Err(PortError::Foreign { port: port.into(), bytes: line.heard_bytes() }),
                Err(Gone) => return Err(gone(port, None)),
            }
            // a device that sends other bytes without end is not a Palpate board
            if begun.elapsed() > patience {
                return Err(PortError::Foreign { port: port.into(), bytes: line.heard_bytes() });
            }
        };
        let nobody = Identity::new(&About { name: "", built_day: 0, clock_hz: 0, image: 0 }, (0, 0.0, 0.0), 0);
        let (heard, silence, keep_alive) = (Instant::now(), SILENCE, false);
        let mut session = Self { line, identity: nobody, record, log, heard, silence, keep_alive };
        session.identity = session.identify()?.ok_or_else(|| PortError::Deaf(port.into()))?;
        Ok(session)
    }

    /// Name of the port.
    pub fn port(&self) -> &str {
        self.line.name()
    }

    /// Time at which the last message was sent.
    pub fn last_sent(&self) -> Instant {
        self.line.last_sent()
    }

    /// Counts of the frames of the board so far.
    pub fn counts(&self) -> Counts {
        self.line.counts()
    }

    /// Asks for the identification; returns `None` without an answer. If a force is still falling,
    /// waits for its end.
    pub fn identify(&mut self) -> Result<Option<Identity>, PortError> {
        let asked = self.ask(&ToBoard::Identify, ANSWER, |message| match message {
            FromBoard::Identity(identity) => Some(identity),
            _ => None,
        })?;
        if let Some(identity) = asked {
            self.identity = identity;
        }
        Ok(asked)
    }

    /// Repeats a request until `picked` finds its answer.
    pub fn ask<T>(
        &mut self,
        request: &ToBoard<'_>,
        patience: Duration,
        picked: impl Fn(FromBoard) -> Option<T>,
    ) -> Result<Option<T>, PortError> {
        let begun = Instant::now();
        while begun.elapsed() < patience {
            self.send(request)?;
            let sent = Instant::now();
            while let Some(message) = self.next(AGAIN.saturating_sub(sent.elapsed()))? {
                if let Some(answer) = picked(message) {
                    return Ok(Some(answer));
                }
            }
        }
        Ok(None)
    }

    /// Sends a message.
    pub fn send(&mut self, message: &ToBoard<'_>) -> Result<(), PortError> {
        self.line.send(message).map_err(|Gone| gone(self.line.name(), Some(&self.record)))
    }

    /// Returns the board's next message, if one arrives within `wait`; sends keep-alive messages
    /// meanwhile, if [`Self::keep_alive`] is set.
    pub fn next(&mut self, wait: Duration) -> Result<Option<FromBoard>, PortError> {
        let begun = Instant::now();
        loop {
            if self.keep_alive && self.line.last_sent().elapsed() >= HEARTBEAT {
                self.send(&ToBoard::Heartbeat)?;
            }
            let left = wait.saturating_sub(begun.elapsed());
            let until_next = HEARTBEAT.saturating_sub(self.line.last_sent().elapsed());
            let slice = if self.keep_alive { left.min(until_next) } else { left };
            match self.line.receive(slice) {
                Ok(Some(message)) => {
                    self.heard = Instant::now();
                    match message {
                        FromBoard::Record(record) => self.record = record,
                        FromBoard::Log(piece) => self.log.push(piece),
                        _ => {}
                    }
                    return Ok(Some(message));
                }
                Ok(None) if self.heard.elapsed() > self.silence => return Err(self.silent()),
                Ok(None) if begun.elapsed() >= wait => return Ok(None),
                Ok(None) => {}
                Err(Gone) => return Err(gone(self.line.name(), Some(&self.record))),
            }
        }
    }

    /// Repeats the request for a stop until the board reports that its outputs are off.
    pub fn stop(&mut self) -> Result<(), PortError> {
        let off = self.ask(&ToBoard::Ask(HostAsk::Stop), STOPPED, |message| match message {
            FromBoard::Record(record) => (!record.enabled && !runs(&record)).then_some(()),
            _ => None,
        })?;
        off.ok_or_else(|| PortError::Undone {
            port: self.port().into(),
            what: format!(
                "the outputs are still on two seconds after the stop was asked for ({}): cut the motors' power",
                force_words(&self.record)
            ),
        })
    }

    fn silent(&self) -> PortError {
        PortError::Lost {
            port: self.port().into(),
            what: "the board has been silent for two seconds: it lost its power, was reset or has crashed;",
            after: after(&self.record),
        }
    }
}

/// Whether a force acts, or may act without another request.
fn runs(record: &Record) -> bool {
    record.mode().is_none_or(|mode| mode.allows_force() || mode == Mode::Arming)
}

fn gone(port: &str, record: Option<&Record>) -> PortError {
    PortError::Lost {
        port: port.into(),
        what: "the port has gone: the cable was pulled, or the board was reset or lost its power;",
        after: record.map_or_else(|| "plug it in and try again".into(), after),
    }
}

/// Describes the force on the device.
pub fn force_words(record: &Record) -> String {
    let [x, y, z] = record.applied_n;
    let whole = (x * x + y * y + z * z).sqrt();
    let mut words = format!("{whole:.3} N");
    if whole > 0.0 {
        // writing to a string does not fail
        let _ = write!(words, " ({x:.3}, {y:.3}, {z:.3})");
    }
    words.push_str(if record.enabled { ", outputs on" } else { ", outputs off" });
    words
}

/// Says whether a force acted, and how it ends now that the board no longer hears its host.
fn after(record: &Record) -> String {
    if !record.mode().is_some_and(Mode::allows_force) {
        return "no force acted; plug it in, then `palpate board status` tells".into();
    }
    format!(
        "a force of {} acted: {}; then `palpate board status` tells",
        force_words(record).trim_end_matches(", outputs on"),
        released_by_itself()
    )
}

/// Says how a board ends the force when it does not hear its host.
pub fn released_by_itself() -> String {
    let ArmingSettings { silence_ticks, ramp_ticks, .. } = ArmingSettings::DEFAULT;
    format!(
        "a board that does not hear its host lowers its force after {silence_ticks} ms and has none after {}",
        silence_ticks + ramp_ticks
    )
}
