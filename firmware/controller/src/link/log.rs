//! A piece of the image's log: frames of defmt's stream encoding (rzCOBS), each with its closing
//! zero. Decoding them to text takes the ELF file of the image that sent them.

use core::fmt;

use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Largest number of log bytes in a message, and so the longest log frame that the link can carry.
pub const LOG_BYTES: usize = 96;

/// Whole frames of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Log {
    /// Number of frames lost since the board's start because its memory was full; 0 in
    /// [`Self::NOTHING`].
    pub lost: u32,
    /// The frames, oldest first.
    pub frames: Frames,
}

impl Log {
    /// Answer to a host when no frame is pending.
    pub const NOTHING: Self = Self { lost: 0, frames: Frames::NONE };
}

/// Bytes of whole frames, at most [`LOG_BYTES`].
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Frames {
    length: u8,
    /// The frames; bytes from `length` on are zero.
    bytes: [u8; LOG_BYTES],
}

impl Frames {
    /// Zero bytes, no frame.
    pub const NONE: Self = Self { length: 0, bytes: [0; LOG_BYTES] };

    /// Copies as many bytes as fit.
    #[must_use]
    pub fn of(bytes: impl Iterator<Item = u8>) -> Self {
        let mut frames = Self::NONE;
        for (place, byte) in frames.bytes.iter_mut().zip(bytes) {
            *place = byte;
            frames.length += 1;
        }
        frames
    }

    /// The frames' bytes, oldest frame first.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.length)).unwrap_or_default()
    }
}

impl fmt::Debug for Frames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.bytes().fmt(f)
    }
}

impl Serialize for Frames {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.bytes())
    }
}

impl<'de> Deserialize<'de> for Frames {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Bytes;

        impl Visitor<'_> for Bytes {
            type Value = Frames;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "at most {LOG_BYTES} bytes")
            }

            fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Frames, E> {
                if bytes.len() > LOG_BYTES {
                    return Err(E::invalid_length(bytes.len(), &self));
                }
                Ok(Frames::of(bytes.iter().copied()))
            }
        }

        deserializer.deserialize_bytes(Bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::frame::{FRAME_BYTES, decode, encode};
    use crate::link::{FrameError, FromBoard};

    #[test]
    fn every_length_goes_over_the_link_and_takes_no_more_than_it_holds() {
        for length in 0..=LOG_BYTES {
            let frames = Frames::of((0..length).map(|n| n as u8));
            assert_eq!(frames.bytes().len(), length);
            let (sent, mut out) = (FromBoard::Log(Log { lost: 300, frames }), [0; FRAME_BYTES]);
            let bytes = encode(7, &sent, &mut out).unwrap().len();
            // stuffing, sequence, message, lost, length, checksum, zero
            assert_eq!(bytes, 1 + 2 + 1 + 2 + 1 + length + 4 + 1);
            assert_eq!(decode::<FromBoard>(&mut out[..bytes - 1]).unwrap(), (7, sent));
        }
        assert_eq!(Frames::of([1; 200].into_iter()).bytes(), [1; LOG_BYTES], "what does not fit is left");
    }

    #[test]
    fn more_bytes_than_a_message_holds_are_no_message() {
        let (mut out, log) = ([0; FRAME_BYTES], FromBoard::Log(Log { lost: 0, frames: Frames::NONE }));
        let number = {
            let bytes = encode(0, &log, &mut out).unwrap().len();
            // stuffed: code, sequence 0, code, code, number of the message
            assert_eq!(out[..3], [1, 1, 2]);
            assert!(bytes < 20);
            out[3]
        };
        // the same message by hand, with one byte too many
        let long = (number, 0_u32, &[1_u8; LOG_BYTES + 1][..]);
        let bytes = encode(0, &long, &mut out).unwrap().len();
        assert_eq!(decode::<FromBoard>(&mut out[..bytes - 1]), Err(FrameError::Message));
        let fits = (number, 0_u32, &[1_u8; LOG_BYTES][..]);
        let bytes = encode(0, &fits, &mut out).unwrap().len();
        assert!(decode::<FromBoard>(&mut out[..bytes - 1]).is_ok());
    }
}
