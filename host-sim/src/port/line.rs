//! Sends and receives frames over a serial port.

use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use palpate_controller::link::frame::FRAME_BYTES;
use palpate_controller::link::receiver::Counts;
use palpate_controller::link::{BAUD, FromBoard, Receiver, ToBoard, encode};
use serialport::{ClearBuffer, SerialPort};

use super::PortError;

/// Longest wait of a frame for room in the system's queue.
const WRITE_PATIENCE: Duration = Duration::from_millis(500);

/// After this silence a board may have restarted, and begins with any sequence number. It sends a
/// record every 2 ms otherwise.
const FORGET: Duration = Duration::from_millis(100);

/// An open port.
pub struct Line {
    port: Box<dyn SerialPort>,
    name: String,
    receiver: Receiver,
    sequence: u16,
    bytes: [u8; 4096],
    read: usize,
    taken: usize,
    heard_bytes: usize,
    last_heard: Instant,
    last_sent: Instant,
}

/// The port has disappeared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gone;

impl Line {
    /// Opens a port for this program alone, without sending anything.
    pub fn open(name: &str) -> Result<Self, PortError> {
        let port = serialport::new(name, BAUD).timeout(WRITE_PATIENCE).open().map_err(|error| refused(name, &error))?;
        // input of an earlier program is dropped; if the system cannot do so, the checksum rejects
        // it
        let _ = port.clear(ClearBuffer::Input);
        Ok(Self {
            port,
            name: name.into(),
            receiver: Receiver::NEW,
            sequence: 0,
            bytes: [0; 4096],
            read: 0,
            taken: 0,
            heard_bytes: 0,
            last_heard: Instant::now(),
            last_sent: Instant::now(),
        })
    }

    /// Name of the port.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of bytes received so far.
    pub fn heard_bytes(&self) -> usize {
        self.heard_bytes
    }

    /// Counts of the frames received so far.
    pub fn counts(&self) -> Counts {
        self.receiver.counts()
    }

    /// Time at which the last message was sent.
    pub fn last_sent(&self) -> Instant {
        self.last_sent
    }

    /// Sends a message.
    pub fn send(&mut self, message: &ToBoard<'_>) -> Result<(), Gone> {
        let mut out = [0; FRAME_BYTES];
        // every message fits a frame
        let frame = encode(self.sequence, message, &mut out).map_err(|_| Gone)?;
        self.sequence = self.sequence.wrapping_add(1);
        self.port.set_timeout(WRITE_PATIENCE).map_err(|_| Gone)?;
        self.port.write_all(frame).map_err(|_| Gone)?;
        self.last_sent = Instant::now();
        Ok(())
    }

    /// Returns the text received within `wait`, from an image that sends text; invalid characters
    /// are replaced.
    pub fn text(&mut self, wait: Duration) -> Result<String, Gone> {
        self.port.set_timeout(wait).map_err(|_| Gone)?;
        match self.port.read(&mut self.bytes) {
            Ok(0) => Err(Gone),
            Ok(came) => Ok(String::from_utf8_lossy(self.bytes.get(..came).unwrap_or_default()).into_owned()),
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock) => {
                Ok(String::new())
            }
            Err(_) => Err(Gone),
        }
    }

    /// Returns the board's next message, if one arrives within `wait`. Damaged frames are counted
    /// and dropped.
    pub fn receive(&mut self, wait: Duration) -> Result<Option<FromBoard>, Gone> {
        let begun = Instant::now();
        loop {
            while let Some(byte) = self.bytes.get(self.taken..self.read).and_then(|left| left.first()) {
                self.taken += 1;
                if let Some(Ok(message)) = self.receiver.push(*byte) {
                    return Ok(Some(message));
                }
            }
            let left = wait.saturating_sub(begun.elapsed());
            self.port.set_timeout(left.max(Duration::from_millis(1))).map_err(|_| Gone)?;
            (self.read, self.taken) = (0, 0);
            match self.port.read(&mut self.bytes) {
                Ok(0) => return Err(Gone),
                Ok(came) => {
                    if self.last_heard.elapsed() >= FORGET {
                        self.receiver.forget();
                    }
                    self.last_heard = Instant::now();
                    self.read = came;
                    self.heard_bytes += came;
                }
                Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock) => {
                    if begun.elapsed() >= wait {
                        return Ok(None);
                    }
                }
                Err(_) => return Err(Gone),
            }
        }
    }
}

/// Says why a port was not opened, with the same words on every operating system.
fn refused(name: &str, error: &serialport::Error) -> PortError {
    use serialport::ErrorKind as Kind;
    let cause = error.to_string();
    let says = |words: &[&str]| words.iter().any(|word| cause.to_lowercase().contains(word));
    match error.kind() {
        Kind::Io(ErrorKind::PermissionDenied) => PortError::Denied(name.into()),
        _ if says(&["busy", "lock", "access is denied"]) => PortError::InUse(name.into()),
        Kind::Io(ErrorKind::NotFound) => PortError::Missing(name.into()),
        Kind::NoDevice if says(&["no such", "cannot find"]) => PortError::Missing(name.into()),
        _ => PortError::Unusable { port: name.into(), cause },
    }
}
