//! Lines on standard output and standard error. Neither a closed pipe, as after
//! `palpate press | head`, nor a full disk ends the run: the remaining output is discarded.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Set once standard output was lost for a reason other than a reader that went.
static LOST: AtomicBool = AtomicBool::new(false);

/// Writes to standard output. The first loss is reported on standard error.
pub fn out(text: Arguments<'_>) {
    if let Err(error) = std::io::stdout().write_fmt(text)
        && error.kind() != ErrorKind::BrokenPipe
        && !LOST.swap(true, Ordering::Relaxed)
    {
        err(format_args!("palpate: standard output: {error}: the run goes on; free some space, and run it again to read it\n"));
    }
}

/// Whether output was lost, other than to a reader that went.
#[must_use]
pub fn lost() -> bool {
    LOST.load(Ordering::Relaxed)
}

/// Writes to standard error.
pub fn err(text: Arguments<'_>) {
    // an error here has no place where it could be reported
    let _ = std::io::stderr().write_fmt(text);
}

/// Prints to standard output as the standard library's macro does, but tolerates a closed pipe.
#[macro_export]
macro_rules! print {
    ($($text:tt)*) => {
        $crate::terminal::out(::core::format_args!($($text)*))
    };
}

/// Prints a line to standard output as the standard library's macro does, but tolerates a closed
/// pipe.
#[macro_export]
macro_rules! println {
    () => {
        $crate::terminal::out(::core::format_args!("\n"))
    };
    ($($text:tt)*) => {
        $crate::terminal::out(::core::format_args!("{}\n", ::core::format_args!($($text)*)))
    };
}

/// Prints a line to standard error as the standard library's macro does, but tolerates a closed
/// pipe.
#[macro_export]
macro_rules! eprintln {
    ($($text:tt)*) => {
        $crate::terminal::err(::core::format_args!("{}\n", ::core::format_args!($($text)*)))
    };
}
