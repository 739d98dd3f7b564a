//! Separates received bytes into frames, and resynchronises at the next zero byte after any error.

use serde::Deserialize;

use super::frame::{self, FRAME_BYTES, FrameError};

/// Frames received so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames whose message was accepted.
    pub good: u32,
    /// Frames dropped with a [`FrameError`].
    pub bad: u32,
    /// Sequence numbers skipped between accepted frames.
    pub lost: u32,
}

/// Collects the bytes of one frame at a time.
#[derive(Clone, Debug)]
pub struct Receiver {
    frame: [u8; FRAME_BYTES],
    length: usize,
    /// Sequence number of the last accepted frame.
    sequence: Option<u16>,
    counts: Counts,
}

impl Receiver {
    /// State before the first byte.
    pub const NEW: Self =
        Self { frame: [0; FRAME_BYTES], length: 0, sequence: None, counts: Counts { good: 0, bad: 0, lost: 0 } };

    /// Processes a byte. The zero that ends a frame returns the frame's message. A frame that is
    /// too long is dropped up to its zero.
    ///
    /// # Errors
    /// Returns the reason for which the frame that just ended was dropped; the frame is counted as
    /// bad.
    pub fn push<'r, Message: Deserialize<'r> + Clone>(&'r mut self, byte: u8) -> Option<Result<Message, FrameError>> {
        self.collect(byte).then(|| self.end_frame(Message::clone))
    }

    /// Collects a byte, and returns whether it ends a frame, which [`Self::end_frame`] has to open
    /// before the next byte comes.
    #[inline]
    pub fn collect(&mut self, byte: u8) -> bool {
        if byte == 0 {
            return self.length > 0; // zeros between frames mean an idle line
        }
        if let Some(free) = self.frame.get_mut(self.length) {
            *free = byte;
        }
        self.length = self.length.saturating_add(1);
        false
    }

    /// Opens the frame that was collected and passes a reference to its message to `then`, because
    /// moving a message of a profile's size copies it.
    ///
    /// # Errors
    /// As [`Self::push`].
    pub fn end_frame<'r, Message: Deserialize<'r>, T>(&'r mut self, then: impl FnOnce(&Message) -> T) -> Result<T, FrameError> {
        let length = core::mem::take(&mut self.length);
        let opened = match self.frame.get_mut(..length) {
            Some(frame) => frame::open(frame),
            None => Err(FrameError::TooLong),
        };
        let error = match opened {
            Ok((sequence, body)) => {
                let step = self.sequence.map_or(1, |last| sequence.wrapping_sub(last).cast_signed());
                let mut rest = postcard::Deserializer::from_bytes(body);
                match (&Message::deserialize(&mut rest), rest.finalize()) {
                    (Ok(message), Ok([])) if step > 0 => {
                        self.counts.lost = self.counts.lost.saturating_add(u32::from(step.unsigned_abs() - 1));
                        self.counts.good = self.counts.good.saturating_add(1);
                        self.sequence = Some(sequence);
                        return Ok(then(message));
                    }
                    (Ok(_), Ok([])) => FrameError::Old,
                    _ => FrameError::Message,
                }
            }
            Err(error) => error,
        };
        self.counts.bad = self.counts.bad.saturating_add(1);
        Err(error)
    }

    /// Accepts any sequence number in the next frame. Call this after a long silence, since a new
    /// host may begin with any number.
    pub fn forget(&mut self) {
        self.sequence = None;
    }

    /// Frames received so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(sequence: u16, message: u32) -> std::vec::Vec<u8> {
        let mut out = [0; FRAME_BYTES];
        frame::encode(sequence, &message, &mut out).unwrap().to_vec()
    }

    fn feed(receiver: &mut Receiver, bytes: &[u8]) -> std::vec::Vec<Result<u32, FrameError>> {
        bytes.iter().filter_map(|byte| receiver.push(*byte)).collect()
    }

    #[test]
    fn frames_come_out_as_they_went_in() {
        let mut receiver = Receiver::NEW;
        for (n, message) in [0, 1, 255, 256, u32::MAX].into_iter().enumerate() {
            assert_eq!(feed(&mut receiver, &frame(n as u16, message)), [Ok(message)]);
        }
        assert_eq!(receiver.counts(), Counts { good: 5, bad: 0, lost: 0 });
    }

    #[test]
    fn a_frame_after_rubbish_is_found() {
        let mut receiver = Receiver::NEW;
        let rubbish = [7_u8; 1_000];
        assert_eq!(feed(&mut receiver, &rubbish), []);
        assert_eq!(feed(&mut receiver, &frame(0, 9)), [Err(FrameError::TooLong)], "the rubbish swallows the frame it runs into");
        assert_eq!(feed(&mut receiver, &frame(1, 9)), [Ok(9)]);
        let cut = frame(2, 9);
        assert_eq!(feed(&mut receiver, &[&cut[..4], &[0]].concat()), [Err(FrameError::Stuffing)]);
        assert_eq!(feed(&mut receiver, &frame(2, 9)), [Ok(9)]);
        assert_eq!(receiver.counts().bad, 2);
    }

    #[test]
    fn old_frames_are_dropped_lost_ones_counted_and_the_number_wraps() {
        let mut receiver = Receiver::NEW;
        assert_eq!(feed(&mut receiver, &frame(u16::MAX - 1, 1)), [Ok(1)]);
        assert_eq!(feed(&mut receiver, &frame(u16::MAX - 1, 1)), [Err(FrameError::Old)]);
        assert_eq!(feed(&mut receiver, &frame(u16::MAX - 9, 1)), [Err(FrameError::Old)]);
        assert_eq!(feed(&mut receiver, &frame(1, 2)), [Ok(2)]);
        assert_eq!(receiver.counts(), Counts { good: 2, bad: 2, lost: 2 });
        for older in [0, u16::MAX, 1] {
            receiver.forget();
            assert_eq!(feed(&mut receiver, &frame(older, 3)), [Ok(3)], "a new host begins with {older}");
        }
    }

    #[test]
    fn a_message_with_something_behind_it_is_none() {
        let mut out = [0; FRAME_BYTES];
        let bytes = frame::encode(0, &(1_u32, 2_u32), &mut out).unwrap();
        let mut receiver = Receiver::NEW;
        assert_eq!(feed(&mut receiver, bytes), [Err(FrameError::Message)]);
    }
}
