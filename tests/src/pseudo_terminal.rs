//! A pseudo-terminal: a serial port with both of its ends here.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, Read};
use std::os::unix::ffi::OsStrExt;

use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// Both ends of a pseudo-terminal. The host's end is kept open, so that the port exists between two
/// hosts. No program that a test starts inherits an end, so that dropping this pulls the cable.
#[derive(Debug)]
pub struct PseudoTerminal {
    /// The device's end.
    pub ours: File,
    theirs: File,
    name: String,
}

impl PseudoTerminal {
    /// Makes one that passes bytes as they are.
    ///
    /// # Errors
    /// The system has none left.
    pub fn open() -> io::Result<Self> {
        let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&ours)?;
        unlockpt(&ours)?;
        let name = ptsname(&ours, Vec::new())?;
        let name = OsStr::from_bytes(name.as_bytes()).to_string_lossy().into_owned();
        let theirs = rustix::fs::open(&name, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty())?;
        let mut raw = tcgetattr(&theirs)?;
        raw.make_raw();
        tcsetattr(&theirs, OptionalActions::Now, &raw)?;
        Ok(Self { ours: ours.into(), theirs: theirs.into(), name })
    }

    /// Name of the port.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Bytes on their way to the host.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn unread_bytes(&self) -> io::Result<u64> {
        Ok(rustix::io::ioctl_fionread(&self.theirs)?)
    }

    /// Bytes of the host that are waiting, possibly none.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn take(&mut self) -> io::Result<Vec<u8>> {
        let waiting = rustix::io::ioctl_fionread(&self.ours)?;
        let mut bytes = vec![0; waiting as usize];
        let came = if bytes.is_empty() { 0 } else { self.ours.read(&mut bytes)? };
        bytes.truncate(came);
        Ok(bytes)
    }
}
