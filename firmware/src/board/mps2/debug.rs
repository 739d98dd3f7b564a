//! The debug channel of an emulated run: standard output of the emulator, which a test decodes.

use semihosting::io::{self, Stdout, Write as _};

use crate::board::{Duty, queues::Shared};

static OUT: Shared<Option<Stdout>> = Shared::new(None);

/// Opens the debug output. A board that serves a host has none, because each write stops the
/// emulator.
pub fn debug_start(duty: &Duty) {
    if !matches!(duty, Duty::Serve(_)) {
        OUT.with(|out| *out = io::stdout().ok());
    }
}

/// Writes bytes of a frame, if the debug output is open.
pub fn debug_write(bytes: &[u8]) {
    OUT.with(|out| {
        if let Some(out) = out {
            // on an error nobody reads the output, and the run continues
            let _ = out.write_all(bytes);
        }
    });
}
