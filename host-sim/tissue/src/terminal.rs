//! Lines on standard output and standard error. A closed pipe, as after `palpate press | head`,
//! ends neither the run nor its result: the remaining output is discarded.

use std::fmt::Arguments;
use std::io::{ErrorKind, Result, Write};

/// Writes to standard output.
///
/// # Panics
/// The output is lost for a reason other than a closed pipe, such as a full disk.
pub fn out(text: Arguments<'_>) {
    kept(std::io::stdout().write_fmt(text));
}

/// Writes to standard error.
///
/// # Panics
/// Panics of [`out`].
pub fn err(text: Arguments<'_>) {
    kept(std::io::stderr().write_fmt(text));
}

fn kept(written: Result<()>) {
    if let Err(error) = written
        && error.kind() != ErrorKind::BrokenPipe
    {
        panic!("cannot write the output: {error}");
    }
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
