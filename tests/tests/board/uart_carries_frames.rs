//! Frames of the link over the emulated board's UART, through its registers and interrupts, byte by
//! byte, while the timer runs.

use std::fs::OpenOptions;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc::{Receiver as Inbox, channel};
use std::time::Duration;

use palpate_controller::link::frame::FRAME_BYTES;
use palpate_controller::link::{FromBoard, Receiver, ToBoard, encode};
use palpate_controller::serve::RECORD_TICKS;
use palpate_tests::emulator::build_firmware;

/// Time limit for a message. A message takes milliseconds; a board that has stopped sending must
/// not hang the tests.
const LONGEST: Duration = Duration::from_secs(300);

/// Next message from the board.
fn next(inbox: &Inbox<FromBoard>) -> FromBoard {
    inbox.recv_timeout(LONGEST).expect("the board fell silent")
}

/// Returns the next report and collects the ticks of the records that come before it.
fn report(inbox: &Inbox<FromBoard>, records: &mut Vec<u32>) -> (u32, u32) {
    loop {
        match next(inbox) {
            FromBoard::State { bad_frames, nodes, .. } => return (bad_frames, nodes),
            FromBoard::Record(record) => records.push(record.tick),
            other => panic!("out of turn: {other:?}"),
        }
    }
}

#[test]
fn reports_come_back_and_a_damaged_frame_is_counted() {
    let elf = build_firmware(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), &[]).unwrap();
    let records = talk(&elf);
    println!("ticks of the records: {records:?}");
    assert!(records.windows(2).all(|pair| pair[1] > pair[0] && pair[1] % RECORD_TICKS == 0), "{records:?}");
}

/// Exchanges messages with a board that has just started and returns the ticks of its records. The
/// emulator's clock is independent of how busy this machine is.
fn talk(elf: &Path) -> Vec<u32> {
    let folder = tempfile::tempdir().unwrap();
    let [to, from] = ["serial.in", "serial.out"].map(|name| folder.path().join(name));
    assert!(Command::new("mkfifo").args([&to, &from]).status().unwrap().success());
    let open = |path: &Path| OpenOptions::new().read(true).write(true).open(path).unwrap();
    let (mut to, mut from) = (open(&to), open(&from));
    let serial = format!("pipe:{}", folder.path().join("serial").display());
    let mut child = Command::new("qemu-system-arm")
        .args(["-machine", "mps2-an386", "-cpu", "cortex-m4", "-nographic", "-monitor", "none", "-serial", &serial])
        .args(["-semihosting-config", "enable=on,target=native,arg=palpate-firmware,arg=uart", "-icount", "shift=3,sleep=off"])
        .arg("-kernel")
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let (sender, inbox) = channel();
    std::thread::spawn(move || {
        let (mut receiver, mut byte) = (Receiver::NEW, [0]);
        while from.read_exact(&mut byte).is_ok() {
            if let Some(message) = receiver.push::<FromBoard>(byte[0])
                && sender.send(message.expect("frames of the board are good")).is_err()
            {
                return;
            }
        }
    });

    let records = exchange(&mut to, &inbox);
    child.kill().unwrap(); // the process started above
    child.wait().unwrap();
    records
}

fn exchange(to: &mut impl Write, inbox: &Inbox<FromBoard>) -> Vec<u32> {
    let mut out = [0; FRAME_BYTES];
    let mut records = Vec::new();
    to.write_all(encode(1, &ToBoard::Report, &mut out).unwrap()).unwrap();
    let (bad, nodes) = report(inbox, &mut records);
    assert_eq!(bad, 0);
    assert!(nodes > 40, "{nodes} nodes");
    let mut damaged = encode(2, &ToBoard::Report, &mut out).unwrap().to_vec();
    damaged[2] ^= 0x10;
    to.write_all(&damaged).unwrap();
    to.write_all(encode(3, &ToBoard::Report, &mut out).unwrap()).unwrap();
    assert_eq!(report(inbox, &mut records).0, 1);
    while records.len() < 5 {
        match next(inbox) {
            FromBoard::Record(record) => records.push(record.tick),
            other => panic!("out of turn: {other:?}"),
        }
    }
    records
}
