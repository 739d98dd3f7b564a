//! A board's end of the link: it reads bytes and writes frames.

use crate::board::Board;
use crate::link::frame::FRAME_BYTES;
use crate::link::log::LOG_BYTES;
use crate::link::{FromBoard, Log, Receiver, Refusal, encode};
use crate::log::{Event, Told};

/// Free space that the link must have before a piece of the log is sent [bytes], so that the next
/// record and an answer still fit.
const LOG_ROOM: usize = 2 * FRAME_BYTES + LOG_BYTES;

/// The link to the host.
pub(super) struct Line {
    pub(super) receiver: Receiver,
    sequence: u16,
    bytes: [u8; FRAME_BYTES],
    read: usize,
    taken: usize,
    /// Ticks for which the host still reads the log.
    pub(super) listens_ticks: u32,
    /// Whether the host has asked since the last piece: if no frame is pending, an empty piece
    /// tells it so.
    pub(super) asked: bool,
    /// State of the loop as the log has reported it.
    pub(super) told: Told,
}

impl Line {
    /// A link on which nothing has been received or sent.
    pub(super) fn silent() -> Self {
        Self {
            receiver: Receiver::NEW,
            sequence: 0,
            bytes: [0; FRAME_BYTES],
            read: 0,
            taken: 0,
            listens_ticks: 0,
            asked: false,
            told: Told::NOTHING,
        }
    }

    /// The next byte, if there is one. In lock-step the call blocks until it arrives, and returns
    /// `None` when the host has gone.
    pub(super) fn byte(&mut self, board: &mut impl Board) -> Option<u8> {
        if self.taken >= self.read {
            self.read = board.link_read(&mut self.bytes);
            self.taken = 0;
        }
        let byte = self.bytes.get(..self.read)?.get(self.taken).copied()?;
        self.taken += 1;
        Some(byte)
    }

    #[inline(never)]
    pub(super) fn refuse(&mut self, board: &mut impl Board, refusal: Refusal) {
        board.log(Event::Refused(refusal));
        self.send(board, &FromBoard::Refused(refusal));
    }

    pub(super) fn send(&mut self, board: &mut impl Board, message: &FromBoard) {
        let mut out = [0; FRAME_BYTES];
        if let Some(frame) = encoded(self.sequence, message, &mut out) {
            self.sequence = self.sequence.wrapping_add(1);
            board.link_write(frame);
        }
    }

    /// Sends a piece of the log, if a host reads it and the link has [`LOG_ROOM`].
    pub(super) fn send_log(&mut self, board: &mut impl Board) {
        if self.listens_ticks > 0
            && board.link_room() >= LOG_ROOM
            && let Some(log) = board.take_log().or(self.asked.then_some(Log::NOTHING))
        {
            self.asked = false;
            self.send(board, &FromBoard::Log(log));
        }
    }
}

/// Encodes a frame. Not generic, so that its code is compiled in this crate, which images build for
/// size.
#[inline(never)]
fn encoded<'out>(sequence: u16, message: &FromBoard, out: &'out mut [u8; FRAME_BYTES]) -> Option<&'out [u8]> {
    encode(sequence, message, out).ok()
}
