//! The task that the emulator's command line names, and its link: two files of the emulator's host,
//! or the UART.

use core::ffi::CStr;

use palpate_controller::force_out::Outputs;
use palpate_controller::script::{LEAD_TICKS, Script};
use semihosting::fs::File;
use semihosting::io::{self, Read as _, Write as _};

use super::{hand, uart};
use crate::board::Duty;
use crate::board::by_interrupt;
use crate::board::queues::{self, Shared};
use palpate_controller::serve::Pace;

/// The task if the emulator's command line names none.
const DEFAULT_SCRIPT: Script = Script { ticks: 10_000, lead_ticks: LEAD_TICKS };

/// Whether the command line asks for a reset after a crash, as on hardware: `TICKS LEAD_TICKS
/// restart`.
pub fn restarts() -> bool {
    let arguments = semihosting::experimental::env::args::<512>();
    arguments.is_ok_and(|words| (&words).filter_map(core::result::Result::ok).nth(3) == Some("restart"))
}

/// The task that the emulator's command line names: `TICKS`, `TICKS LEAD_TICKS`, `lock-step IN OUT`
/// with the paths of two FIFOs, `paced` with the same and perhaps that of a third for the levels of
/// the pins ([`Files::pins`]), or `uart`.
#[cfg_attr(feature = "self-test", expect(dead_code, reason = "the self-test serves none"))]
pub fn duty() -> Duty {
    let Ok(arguments) = semihosting::experimental::env::args::<512>() else { return Duty::Script(DEFAULT_SCRIPT) };
    let mut words = (&arguments).filter_map(core::result::Result::ok).skip(1);
    let first = words.next();
    if let Some("lock-step" | "paced") = first {
        let input = open(words.next(), |path| File::open(path));
        let [output, pins] = [(); 2].map(|()| open(words.next(), |path| File::create(path)));
        let (Some(input), Some(output)) = (input, output) else {
            super::print(format_args!("two FIFOs are needed: IN OUT [PINS]"));
            super::exit(false)
        };
        FILES.with(|link| *link = Some(Files { input, output, pins }));
        if first == Some("paced") {
            hand::to(&[0; 12], false);
            return Duty::Serve(Pace::Timed);
        }
        return Duty::Serve(Pace::LockStep);
    }
    if first == Some("uart") {
        uart::start();
        return Duty::Serve(Pace::Timed);
    }
    let number = |word: Option<&str>| word.and_then(|word| word.parse().ok());
    Duty::Script(Script {
        ticks: number(first).unwrap_or(DEFAULT_SCRIPT.ticks),
        lead_ticks: number(words.next()).unwrap_or(DEFAULT_SCRIPT.lead_ticks),
    })
}

/// Not inlined, since the image would contain three copies.
#[inline(never)]
fn open(word: Option<&str>, how: fn(&CStr) -> io::Result<File>) -> Option<File> {
    let (mut path, word) = ([0_u8; 256], word?.as_bytes());
    path.get_mut(..word.len())?.copy_from_slice(word);
    how(CStr::from_bytes_until_nul(&path).ok()?).ok()
}

/// The files of a lock-step or paced link, in the host's file system.
struct Files {
    input: File,
    output: File,
    /// Where a paced board writes the levels of its pins before each packet, so that what the
    /// motors do can move the hand that the next packet contains: the enable line in a byte, and
    /// three converter codes.
    pins: Option<File>,
}

/// With `None` the link is the UART.
static FILES: Shared<Option<Files>> = Shared::new(None);

/// Reads bytes from the host. In lock-step the whole emulated machine stops until some arrive, and
/// 0 means that the host has gone.
pub fn link_read(bytes: &mut [u8]) -> usize {
    let from_file = FILES.with(|link| {
        link.as_mut().map(|files| if hand::is_there() { paced(files, bytes) } else { files.input.read(bytes).unwrap_or(0) })
    });
    from_file.unwrap_or_else(|| by_interrupt::read(bytes))
}

/// Bit of a packet's length which says that the hand's position is given in encoder counts.
const COUNTED: u8 = 0x80;

/// Reads a packet of a tick's input; the emulated machine stops until it arrives. A packet contains
/// the position of the hand, the number of link bytes that follow, with [`COUNTED`], and these
/// bytes. A packet without link bytes ends the tick's input. The writer of the packets sets the
/// pace, and ends the run by an incomplete packet or by closing the file.
#[inline(never)]
fn paced(Files { input, pins, .. }: &mut Files, bytes: &mut [u8]) -> usize {
    if let Some(pins) = pins {
        let Outputs { enabled, codes } = super::outputs();
        let [[x, x_high], [y, y_high], [z, z_high]] = codes.map(|code| code.0.to_le_bytes());
        // a reader that has gone ends the run at the read below
        _ = pins.write_all(&[enabled.into(), x, x_high, y, y_high, z, z_high]);
    }
    let mut head = [0; 13];
    let mut whole = |bytes: &mut [u8]| {
        if input.read(bytes).ok() != Some(bytes.len()) {
            super::outputs_off();
            super::exit(true);
        }
    };
    whole(&mut head);
    let [words @ .., length] = &head;
    hand::to(words, length & COUNTED != 0);
    match bytes.get_mut(..usize::from(length & !COUNTED)) {
        Some(piece @ [_, ..]) => {
            whole(piece);
            piece.len()
        }
        _ => 0,
    }
}

/// Number of bytes that the link would accept now; a file accepts any number.
pub fn link_room() -> usize {
    if FILES.with(|link| link.is_some()) { usize::MAX } else { queues::room() }
}

/// Sends bytes to the host.
pub fn link_write(bytes: &[u8]) {
    // a host that no longer reads is noticed at the next read from it
    let to_file = FILES.with(|link| link.as_mut().map(|files| files.output.write_all(bytes)));
    if to_file.is_none() {
        uart::write(bytes);
    }
}
