//! A debugger of the emulated board, which uses QEMU's gdb stub over a socket. It reads and writes
//! the memory of the image that is flashed.

use std::io::{self, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Time limit for a reply of the emulator.
const PATIENCE: Duration = Duration::from_secs(120);

/// A connection to the stub of a board that has not started yet (option `-S`).
#[derive(Debug)]
pub struct Debugger {
    socket: UnixStream,
}

impl Debugger {
    /// Connects to the socket, which the emulator opens when it starts.
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

    /// Runs the board to the instruction at this address. The first step leaves the current
    /// instruction, at which a breakpoint would stop the board at once.
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
    pub fn read(&mut self, address: u32, words: usize) -> io::Result<Vec<u32>> {
        let answer = self.ask(&format!("m{address:x},{:x}", 4 * words))?;
        let bytes = bytes(&answer).filter(|bytes| bytes.len() == 4 * words).ok_or_else(|| refused("read", &answer))?;
        Ok(bytes.as_chunks::<4>().0.iter().map(|word| u32::from_le_bytes(*word)).collect())
    }

    /// Writes bytes into memory; code memory can be written too.
    pub fn write(&mut self, address: u32, bytes: &[u8]) -> io::Result<()> {
        self.expect(&format!("M{address:x},{:x}:{}", bytes.len(), hex(bytes)), "OK")
    }

    /// Sends a command to the emulator's monitor.
    pub fn monitor(&mut self, command: &str) -> io::Result<()> {
        self.expect(&format!("qRcmd,{}", hex(command.as_bytes())), "OK")
    }

    /// Disconnects and lets the board run.
    pub fn detach(mut self) -> io::Result<()> {
        match self.expect("D", "OK") {
            // the board runs on at once and may have ended before the acknowledgement arrives
            Err(error) if matches!(error.kind(), io::ErrorKind::BrokenPipe | io::ErrorKind::ConnectionReset) => Ok(()),
            answer => answer,
        }
    }

    fn expect(&mut self, command: &str, expected: &str) -> io::Result<()> {
        let answer = self.ask(command)?;
        if answer == expected { Ok(()) } else { Err(refused(command, &answer)) }
    }

    /// Sends a packet and waits for the reply. Packets are `$text#checksum`; each side acknowledges
    /// the other's packets with `+`.
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
