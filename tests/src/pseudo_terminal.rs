//! A pseudo-terminal: a serial port of which the test holds both ends.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, Read};
use std::os::unix::ffi::OsStrExt;

use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// Both ends of a pseudo-terminal. The host's end stays open, so that the port continues to exist
/// after one host has ended and before the next one starts. Programs that a test starts do not
/// inherit the ends, so dropping this value disconnects the port.
#[derive(Debug)]
pub struct PseudoTerminal {
    /// Device's end.
    pub ours: File,
    theirs: File,
    name: String,
}

impl PseudoTerminal {
    /// Opens a pseudo-terminal in raw mode, which passes bytes unchanged.
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

    /// Path of the port.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of bytes sent to the host that it has not read.
    pub fn unread_bytes(&self) -> io::Result<u64> {
        Ok(rustix::io::ioctl_fionread(&self.theirs)?)
    }

    /// Bytes received from the host, possibly none.
    pub fn take(&mut self) -> io::Result<Vec<u8>> {
        let waiting = rustix::io::ioctl_fionread(&self.ours)?;
        let mut bytes = vec![0; waiting as usize];
        let came = if bytes.is_empty() { 0 } else { self.ours.read(&mut bytes)? };
        bytes.truncate(came);
        Ok(bytes)
    }
}
