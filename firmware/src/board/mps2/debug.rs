//! The debug channel of an emulated run: standard output of the emulator, which a test decodes.

use core::cell::RefCell;

use embassy_sync::blocking_mutex::{Mutex, raw::CriticalSectionRawMutex};
use semihosting::io::{self, Stdout, Write as _};

use crate::board::Duty;

static OUT: Mutex<CriticalSectionRawMutex, RefCell<Option<Stdout>>> = Mutex::new(RefCell::new(None));

/// Opens the debug output. A board that serves a host has none, because each write stops the
/// emulator.
pub fn debug_start(duty: &Duty) {
    if !matches!(duty, Duty::Serve(_)) {
        OUT.lock(|out| *out.borrow_mut() = io::stdout().ok());
    }
}

/// Writes bytes of a frame, if the debug output is open.
pub fn debug_write(bytes: &[u8]) {
    OUT.lock(|out| {
        if let Some(out) = &mut *out.borrow_mut() {
            // on an error nobody reads the output, and the run continues
            let _ = out.write_all(bytes);
        }
    });
}
