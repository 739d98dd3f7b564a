//! The emulator's log of executed instructions.
//!
//! `qemu-system-arm -singlestep -d exec,nochain` writes one line before each instruction, with its
//! address as the second of the numbers in brackets. Two kinds of line cancel the instruction
//! before them, because it will be executed again: an access to a device that comes too early for
//! the instruction counter, and an interrupt during the instruction.

use std::io::BufRead;

/// Why a log could not be read.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The log could not be read.
    #[error("execution log, line {line}: {source}")]
    Read {
        /// Number of the line, from 1.
        line: usize,
        /// I/O error of the operating system.
        source: std::io::Error,
    },
    /// A line in a form unknown to this reader.
    #[error("execution log, line {line}: no address in `{text}`; was it written with `-d exec,nochain` and `-singlestep`?")]
    Malformed {
        /// Number of the line, from 1.
        line: usize,
        /// Text of the line.
        text: String,
    },
}

/// Addresses of the instructions that were executed to their end, in order.
pub struct ExecLog<Input> {
    input: Input,
    line: usize,
    started: Option<u32>,
    text: String,
}

enum Event {
    Start(u32),
    Undo(u32),
}

impl<Input: BufRead> ExecLog<Input> {
    /// Reads a log from its start. The input may be a pipe.
    pub const fn new(input: Input) -> Self {
        Self { input, line: 0, started: None, text: String::new() }
    }

    fn event(&mut self) -> Result<Option<Event>, LogError> {
        self.line += 1;
        let line = self.line;
        self.text.clear();
        match self.input.read_line(&mut self.text) {
            Ok(0) => return Ok(None),
            Ok(_) => {}
            Err(source) => return Err(LogError::Read { line, source }),
        }
        parse(&self.text).map(Some).ok_or_else(|| LogError::Malformed { line, text: self.text.trim_end().to_owned() })
    }
}

fn parse(text: &str) -> Option<Event> {
    let address = |digits: &str| u32::from_str_radix(digits, 16).ok();
    if text.starts_with("Trace ") {
        let inside = text.split_once('[')?.1.split_once(']')?.0;
        Some(Event::Start(address(inside.split('/').nth(1)?)?))
    } else if let Some(rest) = text.strip_prefix("cpu_io_recompile: rewound execution of TB to ") {
        Some(Event::Undo(address(rest.trim_end())?))
    } else if text.starts_with("Stopped execution of TB chain before") {
        Some(Event::Undo(address(text.split_once('[')?.1.split_once(']')?.0)?))
    } else {
        None
    }
}

impl<Input: BufRead> Iterator for ExecLog<Input> {
    type Item = Result<u32, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.event() {
                Err(error) => return Some(Err(error)),
                Ok(None) => return self.started.take().map(Ok),
                Ok(Some(Event::Undo(address))) => {
                    self.started = self.started.filter(|s| *s != address);
                }
                Ok(Some(Event::Start(address))) => {
                    if let Some(done) = self.started.replace(address) {
                        return Some(Ok(done));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ExecLog, LogError};

    fn addresses(log: &str) -> Result<Vec<u32>, LogError> {
        ExecLog::new(log.as_bytes()).collect()
    }

    #[test]
    fn an_instruction_started_twice_counts_once() {
        let log = "Trace 0: 0x7f01 [00800408/000000e4/00000110/ff020201] Reset\n\
                   Trace 0: 0x7f02 [00800408/000000e8/00000110/ff020201] Reset\n\
                   cpu_io_recompile: rewound execution of TB to 000000e8\n\
                   Trace 0: 0x7f03 [00800408/000000e8/00000110/ff038201] Reset\n\
                   Trace 0: 0x7f04 [00800408/000000ea/00000110/ff020201] Reset\n\
                   Stopped execution of TB chain before 0x7f04 [000000ea] Reset\n\
                   Trace 0: 0x7f05 [0080040d/00000200/00000010/ff020201] on_timer\n\
                   Trace 0: 0x7f04 [00800408/000000ea/00000110/ff020201] Reset\n";
        assert_eq!(addresses(log).unwrap(), [0xe4, 0xe8, 0x200, 0xea]);
    }

    #[test]
    fn a_foreign_line_is_named() {
        let error = addresses("Trace 0: 0x1 [0/4/0/0] a\nIN: main\n").unwrap_err();
        assert!(error.to_string().contains("line 2"), "{error}");
    }
}
