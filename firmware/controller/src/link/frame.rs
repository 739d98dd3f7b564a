//! Encoding of a message as bytes on the wire, and its decoding.
//!
//! CRC-32 (IEEE) over sequence number and message detects every error of up to three bits in frames
//! of this length. A flipped bit in a byte that COBS adds can change more bits; such an error stays
//! undetected with a probability of 2^-32.

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc};
use serde::{Deserialize, Serialize};

use super::stuffing;

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
/// Length of the sequence number, which precedes the message [bytes].
const HEAD: usize = 2;
/// Length of the checksum, which follows the message [bytes].
const TAIL: usize = 4;
/// Longest message [bytes]: a piece of a patch with its offset, or a record, with some reserve.
pub const BODY_BYTES: usize = 240;
/// Longest frame with its closing zero [bytes]: COBS adds one byte to frames below 254 bytes.
pub const FRAME_BYTES: usize = HEAD + BODY_BYTES + TAIL + 2;

/// Why a frame was dropped, or could not be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// The frame is longer than [`FRAME_BYTES`].
    TooLong,
    /// The byte stuffing is broken.
    Stuffing,
    /// The checksum does not match.
    Checksum,
    /// The checksum matches, but the content is no message of this version.
    Message,
    /// The sequence number is not newer than that of the last frame.
    Old,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooLong => "the frame is too long",
            Self::Stuffing => "the frame's byte stuffing is broken",
            Self::Checksum => "the frame's checksum does not match",
            Self::Message => "the frame holds no message of this version",
            Self::Old => "the frame is not newer than the last one",
        })
    }
}

impl core::error::Error for FrameError {}

/// Writes a message as a frame, including its closing zero.
///
/// # Errors
/// Fails with [`FrameError::TooLong`] if the message does not fit into a frame.
pub fn encode<'out>(sequence: u16, message: &impl Serialize, out: &'out mut [u8; FRAME_BYTES]) -> Result<&'out [u8], FrameError> {
    // written after the place of the first code byte, so that nothing is copied
    let [_, plain @ ..] = &mut *out;
    let (head, rest) = plain.split_at_mut(HEAD);
    head.copy_from_slice(&sequence.to_le_bytes());
    let (body, _) = rest.split_at_mut(BODY_BYTES);
    let body = postcard::to_slice(message, body).map_err(|_| FrameError::TooLong)?.len();
    let (checked, tail) = plain.split_at_mut_checked(HEAD + body).ok_or(FrameError::TooLong)?;
    let crc = CRC.checksum(checked).to_le_bytes();
    *tail.first_chunk_mut().ok_or(FrameError::TooLong)? = crc;
    let length = 1 + HEAD + body + TAIL;
    let (frame, end) = out.split_at_mut_checked(length).ok_or(FrameError::TooLong)?;
    stuffing::stuff(frame).ok_or(FrameError::TooLong)?;
    *end.first_mut().ok_or(FrameError::TooLong)? = 0;
    out.get(..=length).ok_or(FrameError::TooLong)
}

/// Opens a frame without its closing zero, in place; returns sequence number and encoded message.
///
/// # Errors
/// [`FrameError::TooLong`], [`FrameError::Stuffing`] and [`FrameError::Checksum`].
pub fn open(frame: &mut [u8]) -> Result<(u16, &[u8]), FrameError> {
    if frame.len() >= FRAME_BYTES {
        return Err(FrameError::TooLong);
    }
    let length = stuffing::unstuff(frame).ok_or(FrameError::Stuffing)?;
    let plain = frame.get(..length).ok_or(FrameError::Stuffing)?;
    let (checked, crc) = plain.split_last_chunk::<TAIL>().ok_or(FrameError::Checksum)?;
    if CRC.checksum(checked) != u32::from_le_bytes(*crc) {
        return Err(FrameError::Checksum);
    }
    let (sequence, body) = checked.split_first_chunk::<HEAD>().ok_or(FrameError::Checksum)?;
    Ok((u16::from_le_bytes(*sequence), body))
}

/// Decodes a frame without its closing zero, in place; returns sequence number and message.
///
/// # Errors
/// Every [`FrameError`] except [`FrameError::Old`].
pub fn decode<'b, Message: Deserialize<'b>>(frame: &'b mut [u8]) -> Result<(u16, Message), FrameError> {
    let (sequence, body) = open(frame)?;
    match postcard::take_from_bytes(body) {
        Ok((message, [])) => Ok((sequence, message)),
        _ => Err(FrameError::Message),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_body_fills_a_frame_and_a_longer_one_is_refused() {
        // a slice is preceded by a length of two bytes
        let longest = &[0x5A_u8; BODY_BYTES - 2][..];
        let mut out = [0; FRAME_BYTES];
        assert_eq!(encode(7, &longest, &mut out).unwrap().len(), FRAME_BYTES);
        let (last, frame) = out.split_last_mut().unwrap();
        assert_eq!(*last, 0);
        assert_eq!(decode::<&[u8]>(frame), Ok((7, longest)));
        assert_eq!(encode(7, &&[0x5A_u8; BODY_BYTES - 1][..], &mut out), Err(FrameError::TooLong));
        assert_eq!(decode::<&[u8]>(&mut [1; FRAME_BYTES]), Err(FrameError::TooLong));
    }
}
