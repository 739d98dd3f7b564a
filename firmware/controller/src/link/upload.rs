//! Memory for a patch that arrives over the link in pieces.

use super::message::ToBoard;
use crate::refusal::Refusal;

/// Bytes of a patch per frame.
pub const PIECE_BYTES: usize = 192;

/// Memory for an uploaded patch [32-bit words]: 52 KB, enough for some 180 nodes, or 24 KB for 88.
pub const UPLOAD_WORDS: usize = if cfg!(feature = "small-ram") { 6 * 1024 } else { 13 * 1024 };

/// The messages that transfer a patch, in order. The board answers the last one.
pub fn messages(patch: &[u8]) -> impl Iterator<Item = ToBoard<'_>> {
    let parts = patch.chunks(PIECE_BYTES).zip((0..).step_by(PIECE_BYTES)).map(|(bytes, at)| ToBoard::PatchPart { at, bytes });
    [ToBoard::PatchBegin(patch.len() as u32)].into_iter().chain(parts).chain([ToBoard::PatchEnd])
}

/// The memory, and how much of the patch has been received.
pub struct Upload {
    words: [u32; UPLOAD_WORDS],
    announced: usize,
    have: usize,
}

impl Upload {
    /// The initial value of reserved memory.
    pub const RESERVED: Self = Self { words: [0; UPLOAD_WORDS], announced: 0, have: 0 };

    /// Announces a patch of this many bytes; any earlier upload is discarded.
    ///
    /// # Errors
    /// [`Refusal::PatchTooLong`] if it does not fit; an earlier upload then remains.
    pub fn begin(&mut self, bytes: u32) -> Result<(), Refusal> {
        let bytes = usize::try_from(bytes).map_err(|_| Refusal::PatchTooLong)?;
        if bytes > size_of_val(&self.words) {
            return Err(Refusal::PatchTooLong);
        }
        (self.announced, self.have) = (bytes, 0);
        Ok(())
    }

    /// Appends a piece of the patch that begins at byte `at`.
    ///
    /// # Errors
    /// [`Refusal::PatchPieces`] if the piece is not the next one; the upload then has to start
    /// again.
    pub fn part(&mut self, at: u32, piece: &[u8]) -> Result<(), Refusal> {
        let next = u32::try_from(self.have).is_ok_and(|have| have == at);
        let end = self.have.saturating_add(piece.len());
        let room = bytemuck::cast_slice_mut::<u32, u8>(&mut self.words).get_mut(self.have..end);
        match room {
            Some(room) if next && end <= self.announced => {
                room.iter_mut().zip(piece).for_each(|(place, byte)| *place = *byte);
                self.have = end;
                Ok(())
            }
            _ => {
                (self.announced, self.have) = (0, 0);
                Err(Refusal::PatchPieces)
            }
        }
    }

    /// The whole patch, once it is complete.
    ///
    /// # Errors
    /// [`Refusal::PatchPieces`] if it is incomplete.
    pub fn whole(&self) -> Result<&[u8], Refusal> {
        if self.announced == 0 || self.have != self.announced {
            return Err(Refusal::PatchPieces);
        }
        bytemuck::cast_slice(&self.words).get(..self.have).ok_or(Refusal::PatchPieces)
    }
}

#[cfg(test)]
mod tests {
    use std::boxed::Box;

    use super::*;

    #[test]
    fn a_patch_is_whole_once_every_piece_has_come_in_order() {
        let mut upload = Box::new(Upload::RESERVED);
        assert_eq!(upload.whole(), Err(Refusal::PatchPieces), "nothing was announced");
        upload.begin(6).unwrap();
        assert_eq!(upload.whole(), Err(Refusal::PatchPieces), "nothing has come");
        upload.part(0, &[1, 2, 3, 4]).unwrap();
        assert_eq!(upload.whole(), Err(Refusal::PatchPieces), "two bytes are missing");
        upload.part(4, &[5, 6]).unwrap();
        assert_eq!(upload.whole(), Ok(&[1, 2, 3, 4, 5, 6][..]));
    }

    #[test]
    fn a_piece_that_is_repeated_skipped_or_too_long_gives_up_the_patch() {
        for (at, piece) in [(0, &[9_u8, 9][..]), (3, &[9]), (2, &[9; 5])] {
            let mut upload = Box::new(Upload::RESERVED);
            upload.begin(6).unwrap();
            upload.part(0, &[1, 2]).unwrap();
            assert_eq!(upload.part(at, piece), Err(Refusal::PatchPieces), "{at}");
            assert_eq!(upload.part(2, &[3, 4, 5, 6]), Err(Refusal::PatchPieces), "{at}: begins anew");
        }
    }

    #[test]
    fn a_patch_longer_than_the_memory_is_refused() {
        let mut upload = Box::new(Upload::RESERVED);
        assert_eq!(upload.begin(52 * 1024), Ok(()));
        assert_eq!(upload.begin(52 * 1024 + 1), Err(Refusal::PatchTooLong));
    }
}
