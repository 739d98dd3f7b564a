//! The controller with a host on its link, at one of two paces.
//!
//! * **Timed**: the tick timer begins a tick, the board's own sensors give the pose, the link is emptied without waiting, and a record goes out every
//!   [`RECORD_TICKS`]. A silent host is lost after 20 ticks and the force falls to nothing.
//! * **Lock-step**: the host's pose begins a tick, its record ends it. No timer runs, so nothing is ever late. The emulator stands still while the
//!   board waits for the host: a run is the same to the bit whatever the machine does.

use palpate::haptic::device::{Sensed, SensorStatus};
use palpate_firmware::config;
use palpate_firmware::link::desk::Reply;
use palpate_firmware::link::frame::FRAME_BYTES;
use palpate_firmware::link::{Change, Desk, FromBoard, Receiver, Refusal, ToBoard, Upload, encode};
use palpate_firmware::patch::{self, Memory, Patch, Tissue};

use crate::board;
use crate::haptic_loop::{self, HapticLoop};

/// Timed, every so many ticks a record goes out: 50 a second, half of what a link of 115 200 baud carries.
const RECORD_TICKS: u32 = 20;
/// A host that was silent for so many ticks may come back with any sequence number.
const FORGET_TICKS: u32 = 100;

/// What begins a tick.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// The tick timer.
    Timed,
    /// The host's pose.
    LockStep,
}

/// Where the patch lies.
#[derive(Clone, Copy, PartialEq)]
enum Source {
    Flash,
    Uploaded,
    /// On its way, or refused.
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
    /// The next byte, if there is one. In lock-step it is waited for, and the run ends when the host has gone.
    fn byte(&mut self, pace: Pace) -> Option<u8> {
        if self.taken >= self.read {
            self.read = board::link_read(&mut self.bytes);
            self.taken = 0;
            if self.read == 0 && pace == Pace::LockStep {
                board::outputs_off();
                board::exit(true);
            }
        }
        let byte = self.bytes.get(..self.read)?.get(self.taken).copied()?;
        self.taken += 1;
        Some(byte)
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
pub async fn run(mut haptic: HapticLoop, memory: &'static mut Memory, upload: &'static mut Upload, pace: Pace) {
    let mut line = Line { receiver: Receiver::NEW, sequence: 0, bytes: [0; FRAME_BYTES], read: 0, taken: 0 };
    let (mut source, mut modulus_pa, mut before_pa) = (Source::Flash, None, None);
    let mut asked_for = false;
    let mut desk = Desk::default();
    loop {
        let bytes = match source {
            Source::Flash => Ok(Some(patch::in_flash())),
            Source::Uploaded => upload.whole().map(Some),
            Source::Nowhere => Ok(None),
        };
        let change = match bytes {
            Ok(None) => Ok(serve(&mut haptic, &mut Tissue(None), Some(upload), &mut desk, &mut line, pace).await),
            Ok(Some(bytes)) => match Patch::open_within(&board::budget(), bytes, memory, modulus_pa) {
                Ok(patch) => {
                    let mut tissue = Tissue(Some(patch));
                    if asked_for {
                        line.send(&FromBoard::PatchTaken(tissue.state().0 as u32));
                    }
                    before_pa = modulus_pa;
                    Ok(serve(&mut haptic, &mut tissue, None, &mut desk, &mut line, pace).await)
                }
                Err(error) => Err(error.into()),
            },
            Err(refusal) => Err(refusal),
        };
        asked_for = false;
        let refusal = match change {
            Ok(Change::MakeRoom(bytes)) => match upload.begin(bytes) {
                Ok(()) => {
                    (source, modulus_pa) = (Source::Nowhere, None);
                    continue;
                }
                Err(refusal) => refusal,
            },
            Ok(Change::Take) => {
                (source, asked_for) = (Source::Uploaded, true);
                continue;
            }
            Ok(Change::Modulus(pascal)) => {
                (before_pa, modulus_pa, asked_for) = (modulus_pa, Some(pascal), true);
                continue;
            }
            // the same patch as it was
            Err(refusal) if modulus_pa != before_pa => {
                modulus_pa = before_pa;
                refusal
            }
            // nobody arms on a tissue that was not asked for, nor on none
            Err(refusal) => {
                source = Source::Nowhere;
                refusal
            }
        };
        line.send(&FromBoard::Refused(refusal));
    }
}

/// Ticks with one patch until the host wants another.
async fn serve(
    haptic: &mut HapticLoop,
    tissue: &mut Tissue<'_>,
    mut upload: Option<&mut Upload>,
    desk: &mut Desk,
    line: &mut Line,
    pace: Pace,
) -> Change {
    let mut newest = Sensed { position_m: palpate::Vector3::zeros(), sequence: 0, status: SensorStatus::Failed };
    let mut silent_ticks = 0_u32;
    loop {
        let period = match pace {
            Pace::Timed => Some(haptic_loop::next_period().await),
            Pace::LockStep => None,
        };
        while let Some(byte) = line.byte(pace) {
            let reply = match line.receiver.push::<ToBoard<'_>>(byte) {
                Some(Ok(message)) => desk.take(&message, &mut haptic.controller, upload.as_deref_mut()),
                Some(Err(_)) | None => continue,
            };
            match reply {
                Reply::Tick if pace == Pace::LockStep => break,
                Reply::None | Reply::Tick => {}
                Reply::Refused(refusal) => line.send(&FromBoard::Refused(refusal)),
                Reply::Change(change) => return change,
                Reply::Modulus(pascal) => {
                    if let Err(refusal) = tissue.ask_modulus(pascal) {
                        line.send(&FromBoard::Refused(refusal));
                    }
                }
                Reply::Store(profile) => {
                    let kept = config::store(&mut board::ProfileMemory, &profile).map_err(Refusal::from);
                    let kept = kept.and_then(|generation| {
                        let (settings, edge) = profile.split();
                        haptic.controller.restart(&settings, edge).map(|()| generation).map_err(|_| Refusal::ProfileRange)
                    });
                    line.send(&kept.map_or_else(FromBoard::Refused, FromBoard::Stored));
                }
                // a scan of the stack takes a third of a tick: not under a hand's force
                Reply::Report if pace == Pace::Timed && haptic.controller.mode().allows_force() => {
                    line.send(&FromBoard::Refused(Refusal::NotIdle));
                }
                Reply::Report => report(tissue, line),
            }
        }
        let (sensed, command) = desk.clear();
        silent_ticks = if command.heard { 0 } else { silent_ticks.saturating_add(1) };
        if silent_ticks == FORGET_TICKS {
            line.receiver.forget();
        }
        newest = board::sense().or(sensed).unwrap_or(newest);
        let record = haptic.tick(tissue, newest, command, period);
        // when the force is out: weighing 57 nodes anew takes 4500 instructions, 146 take 9200
        tissue.settle(haptic.controller.in_contact());
        if pace == Pace::LockStep || record.tick.is_multiple_of(RECORD_TICKS) {
            line.send(&FromBoard::Record(record));
        }
    }
}

fn report(tissue: &Tissue<'_>, line: &mut Line) {
    let (nodes, state_hash) = tissue.state();
    line.send(&FromBoard::State {
        state_hash,
        stack_used_bytes: board::stack_used_bytes() as u32,
        bad_frames: line.receiver.counts().bad,
        nodes: nodes as u32,
    });
}
