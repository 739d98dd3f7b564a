//! A ring of bytes between the haptic loop and the interrupt of a UART. Frames are copied as a
//! whole, since interrupts are off meanwhile. Not generic, so that its code is compiled in this
//! crate, which images build for size.

use super::FRAME_BYTES;

/// Room for three of the longest frames, or for 8 ms of bytes at [`super::BAUD`].
const QUEUE_BYTES: usize = 3 * FRAME_BYTES;

/// Bytes that wait.
#[derive(Debug)]
pub struct ByteQueue {
    bytes: [u8; QUEUE_BYTES],
    /// Place of the oldest byte.
    first: usize,
    len: usize,
}

impl ByteQueue {
    /// A queue without bytes.
    pub const EMPTY: Self = Self { bytes: [0; QUEUE_BYTES], first: 0, len: 0 };

    /// Number of bytes that there is room for.
    #[must_use]
    pub fn room(&self) -> usize {
        QUEUE_BYTES - self.len
    }

    /// Queues a frame, or drops it if it does not fit as a whole.
    #[inline(never)]
    pub fn write(&mut self, frame: &[u8]) {
        let from = place(self.first + self.len);
        if self.room() >= frame.len()
            && let Some((start, end)) = self.bytes.split_at_mut_checked(from)
        {
            let (first, rest) = frame.split_at_checked(end.len()).unwrap_or((frame, &[]));
            copy(end, first);
            copy(start, rest);
            self.len += frame.len();
        }
    }

    /// Moves the oldest bytes to `bytes`, and returns their number.
    #[inline(never)]
    pub fn read(&mut self, bytes: &mut [u8]) -> usize {
        let mut count = 0;
        for place in bytes {
            let Some(byte) = self.pop() else { break };
            *place = byte;
            count += 1;
        }
        count
    }

    /// Queues a byte. If it does not fit it is lost, and its frame is dropped for its checksum.
    pub fn push(&mut self, byte: u8) {
        if self.room() > 0
            && let Some(free) = self.bytes.get_mut(place(self.first + self.len))
        {
            *free = byte;
            self.len += 1;
        }
    }

    /// The oldest bytes, up to the end of the ring's memory.
    #[must_use]
    pub fn first_piece(&self) -> &[u8] {
        let end = QUEUE_BYTES.min(self.first + self.len);
        self.bytes.get(self.first..end).unwrap_or(&[])
    }

    /// Removes the oldest bytes, at most all.
    pub fn remove(&mut self, count: usize) {
        let count = count.min(self.len);
        self.len -= count;
        self.first = place(self.first + count);
    }

    /// Removes the oldest byte.
    #[inline]
    pub fn pop(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.first)?;
        self.len = self.len.checked_sub(1)?;
        self.first = place(self.first + 1);
        Some(byte)
    }
}

/// A place in the ring, from a number below twice its size.
#[inline]
fn place(at: usize) -> usize {
    at.checked_sub(QUEUE_BYTES).unwrap_or(at)
}

/// Copies bytes as far as there are some and there is room.
#[inline(never)]
fn copy(to: &mut [u8], from: &[u8]) {
    let count = to.len().min(from.len());
    if let (Some(to), Some(from)) = (to.get_mut(..count), from.get(..count)) {
        to.copy_from_slice(from);
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    #[test]
    fn bytes_come_out_in_order_and_a_frame_without_room_is_dropped_whole() {
        let mut queue = ByteQueue::EMPTY;
        let (mut sent, mut came, mut next) = (Vec::<u8>::new(), Vec::<u8>::new(), 0_u8);
        for round in 0..40 {
            let frame: Vec<u8> = (0..FRAME_BYTES - round).map(|n| next.wrapping_add(n as u8)).collect();
            let fits = queue.room() >= frame.len();
            let before = queue.room();
            queue.write(&frame);
            assert_eq!(before - queue.room(), if fits { frame.len() } else { 0 }, "round {round}");
            if fits {
                sent.extend(&frame);
                next = next.wrapping_add(frame.len() as u8);
            }
            let mut bytes = [0; 100];
            let count = queue.read(&mut bytes);
            came.extend(&bytes[..count]);
        }
        while !queue.first_piece().is_empty() {
            // a piece that is not removed stays
            let piece = queue.first_piece().to_vec();
            assert_eq!(queue.first_piece(), piece);
            queue.remove(piece.len());
            came.extend(piece);
        }
        queue.remove(1);
        assert_eq!((queue.pop(), queue.room()), (None, QUEUE_BYTES));
        assert!(sent.len() > 3 * QUEUE_BYTES && sent.len() < 40 * (FRAME_BYTES - 40), "some were dropped");
        assert_eq!(came, sent);
    }
}
