//! A debugger on the emulated board: QEMU's gdb stub, over a socket. It reads and writes the memory
//! of the image that is flashed.

use std::io::{self, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Longest wait for an answer of the emulator.
const PATIENCE: Duration = Duration::from_secs(120);

/// A connection to the stub of a board that has not started yet (`-S`).
#[derive(Debug)]
pub struct Debugger {
    socket: UnixStream,
}

impl Debugger {
    /// Connects to the emulator, which opens the socket when it starts.
    ///
    /// # Errors
    /// No emulator answers.
    pub fn connect(socket: &Path) -> io::Result<Self> {
        let begun = Instant::now();
        let socket = loop {
            match UnixStream::connect(socket) {
                Ok(socket) => break socket,
                Err(error) if begun.elapsed() > PATIENCE => return Err(error),
                Err(_) => sleep(Duration::from_millis(5)),
            }
        };
        socket.set_read_timeout(Some(PATIENCE))?;
        Ok(Self { socket })
    }

    /// Lets the board run to the instruction at this address. It first leaves the present one: a
    /// breakpoint there would stop it at once.
    ///
    /// # Errors
    /// The run ended before.
    pub fn run_to(&mut self, address: u32) -> io::Result<()> {
        self.stopped("s")?;
        self.expect(&format!("Z1,{address:x},2"), "OK")?;
        self.stopped("c")?;
        self.expect(&format!("z1,{address:x},2"), "OK")
    }

    fn stopped(&mut self, how: &str) -> io::Result<()> {
        let answer = self.ask(how)?;
        if answer.starts_with('T') { Ok(()) } else { Err(refused(how, &answer)) }
    }

    /// Reads words of memory.
    ///
    /// # Errors
    /// No memory is at this address.
    pub fn read(&mut self, address: u32, words: usize) -> io::Result<Vec<u32>> {
        let answer = self.ask(&format!("m{address:x},{:x}", 4 * words))?;
        let bytes = bytes(&answer).filter(|bytes| bytes.len() == 4 * words).ok_or_else(|| refused("read", &answer))?;
        Ok(bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect())
    }

    /// Writes bytes into memory, also into code.
    ///
    /// # Errors
    /// No memory is at this address.
    pub fn write(&mut self, address: u32, bytes: &[u8]) -> io::Result<()> {
        self.expect(&format!("M{address:x},{:x}:{}", bytes.len(), hex(bytes)), "OK")
    }

    /// Gives the emulator a command of its monitor.
    ///
    /// # Errors
    /// The command is refused or answers anything.
    pub fn monitor(&mut self, command: &str) -> io::Result<()> {
        self.expect(&format!("qRcmd,{}", hex(command.as_bytes())), "OK")
    }

    /// Lets the board run.
    ///
    /// # Errors
    /// The stub refuses.
    pub fn detach(mut self) -> io::Result<()> {
        match self.expect("D", "OK") {
            // the board continues from there, and may have ended before the acknowledgement arrives
            Err(error) if matches!(error.kind(), io::ErrorKind::BrokenPipe | io::ErrorKind::ConnectionReset) => Ok(()),
            answer => answer,
        }
    }

    fn expect(&mut self, command: &str, expected: &str) -> io::Result<()> {
        let answer = self.ask(command)?;
        if answer == expected { Ok(()) } else { Err(refused(command, &answer)) }
    }

    /// Sends a packet and waits for the answer; packets are `$text#checksum`, each side
    /// acknowledges the other's with `+`.
    fn ask(&mut self, command: &str) -> io::Result<String> {
        let sum = command.bytes().fold(0_u8, u8::wrapping_add);
        write!(self.socket, "${command}#{sum:02x}")?;
        let mut byte = [0_u8];
        let mut next = |socket: &mut UnixStream| socket.read_exact(&mut byte).map(|()| byte[0]);
        while next(&mut self.socket)? != b'$' {}
        let mut answer = String::new();
        loop {
            match next(&mut self.socket)? {
                b'#' => break,
                letter => answer.push(char::from(letter)),
            }
        }
        let _checksum = [next(&mut self.socket)?, next(&mut self.socket)?];
        self.socket.write_all(b"+")?;
        Ok(answer)
    }
}

fn refused(command: &str, answer: &str) -> io::Error {
    io::Error::other(format!("the debugger's {command:?} was answered by {answer:?}"))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn bytes(hex: &str) -> Option<Vec<u8>> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(hex.get(at..at + 2)?, 16).ok()).collect()
}
