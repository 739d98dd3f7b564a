//! A host drives the controller in lock-step: the link's pose begins a tick, its record ends it. No timer runs, so nothing is ever late.
//!
//! The emulator stands still while the board waits for the host: a run is the same to the bit whatever the machine does.

use palpate::haptic::device::{Sensed, SensorStatus};
use palpate_firmware::config;
use palpate_firmware::link::desk::Reply;
use palpate_firmware::link::frame::FRAME_BYTES;
use palpate_firmware::link::{Change, Desk, FromBoard, Receiver, Refusal, ToBoard, Upload, encode};
use palpate_firmware::patch::{self, Memory, Patch, Tissue};

use crate::board;
use crate::haptic_loop::HapticLoop;

/// Where the patch lies.
#[derive(Clone, Copy, PartialEq)]
enum Source {
    Flash,
    Uploaded,
    /// On its way.
    Nowhere,
}

/// The link to the host.
struct Line {
    receiver: Receiver,
    sequence: u16,
    bytes: [u8; FRAME_BYTES],
    read: usize,
    taken: usize,
}

impl Line {
    /// The next byte; waits for it. Ends the run when the host has gone.
    fn byte(&mut self) -> u8 {
        while self.taken >= self.read {
            self.read = board::link_read(&mut self.bytes);
            self.taken = 0;
            if self.read == 0 {
                board::outputs_off();
                board::exit(true);
            }
        }
        let byte = self.bytes.get(self.taken).copied().unwrap_or(0);
        self.taken += 1;
        byte
    }

    fn send(&mut self, message: &FromBoard) {
        let mut out = [0; FRAME_BYTES];
        if let Ok(frame) = encode(self.sequence, message, &mut out) {
            self.sequence = self.sequence.wrapping_add(1);
            board::link_write(frame);
        }
    }
}

/// Serves a host until it goes.
#[embassy_executor::task]
pub async fn run(mut haptic: HapticLoop, memory: &'static mut Memory, upload: &'static mut Upload) {
    let mut line = Line { receiver: Receiver::NEW, sequence: 0, bytes: [0; FRAME_BYTES], read: 0, taken: 0 };
    let (mut source, mut modulus_pa) = (Source::Flash, None);
    let mut asked_for = false;
    loop {
        let mut with = |bytes| {
            let mut tissue = Tissue(Some(Patch::open(bytes, memory, modulus_pa)?));
            if asked_for {
                line.send(&FromBoard::PatchTaken(tissue.state().0 as u32));
            }
            Ok(serve(&mut haptic, &mut tissue, None, &mut line))
        };
        let change = match source {
            Source::Flash => with(patch::in_flash()),
            Source::Uploaded => upload.whole().and_then(with),
            Source::Nowhere => Ok(serve(&mut haptic, &mut Tissue(None), Some(upload), &mut line)),
        };
        asked_for = false;
        let refusal = match change {
            Ok(Change::MakeRoom(bytes)) => {
                (source, modulus_pa) = (Source::Flash, None); // the memory is given up in any case
                match upload.begin(bytes) {
                    Ok(()) => {
                        source = Source::Nowhere;
                        continue;
                    }
                    Err(refusal) => refusal,
                }
            }
            Ok(Change::Take) => {
                (source, asked_for) = (Source::Uploaded, true);
                continue;
            }
            Ok(Change::Modulus(pascal)) => {
                (modulus_pa, asked_for) = (Some(pascal), true);
                continue;
            }
            Err(refusal) if modulus_pa.take().is_some() => refusal, // the same patch as it was packed
            Err(refusal) => {
                source = Source::Flash;
                refusal
            }
        };
        line.send(&FromBoard::Refused(refusal));
    }
}

/// Ticks with one patch until the host wants another.
fn serve(haptic: &mut HapticLoop, tissue: &mut Tissue<'_>, mut upload: Option<&mut Upload>, line: &mut Line) -> Change {
    let mut desk = Desk::default();
    let mut newest = Sensed { position_m: palpate::Vector3::zeros(), sequence: 0, status: SensorStatus::Failed };
    loop {
        let byte = line.byte();
        let reply = match line.receiver.push::<ToBoard<'_>>(byte) {
            Some(Ok(message)) => desk.take(&message, &mut haptic.controller, upload.as_deref_mut()),
            Some(Err(_)) | None => continue,
        };
        match reply {
            Reply::None => {}
            Reply::Tick => {
                let (sensed, command) = desk.clear();
                newest = sensed.unwrap_or(newest);
                let record = haptic.tick(tissue, newest, command, None);
                line.send(&FromBoard::Record(record));
            }
            Reply::Refused(refusal) => line.send(&FromBoard::Refused(refusal)),
            Reply::Change(change) => return change,
            Reply::Store(profile) => {
                let kept = config::store(&mut board::ProfileMemory, &profile).map_err(Refusal::from);
                line.send(&kept.map_or_else(FromBoard::Refused, FromBoard::Stored));
            }
            Reply::Report => {
                let (nodes, state_hash) = tissue.state();
                line.send(&FromBoard::State {
                    state_hash,
                    stack_used_bytes: board::stack_used_bytes() as u32,
                    bad_frames: line.receiver.counts().bad,
                    nodes: nodes as u32,
                });
            }
        }
    }
}
