//! Memory for a patch that comes over the link, piece by piece.

use super::message::Refusal;

/// Words for an uploaded patch: 64 KB, some 220 nodes.
pub const UPLOAD_WORDS: usize = 16 * 1024;

/// The memory, and how much of it has come.
pub struct Upload {
    words: [u32; UPLOAD_WORDS],
    announced: usize,
    have: usize,
}

impl Upload {
    /// As it is reserved.
    pub const RESERVED: Self = Self { words: [0; UPLOAD_WORDS], announced: 0, have: 0 };

    /// A patch of so many bytes will come; what there was is gone.
    ///
    /// # Errors
    /// [`Refusal::PatchTooLong`]: what there was stays.
    pub fn begin(&mut self, bytes: u32) -> Result<(), Refusal> {
        let bytes = usize::try_from(bytes).map_err(|_| Refusal::PatchTooLong)?;
        if bytes > size_of_val(&self.words) {
            return Err(Refusal::PatchTooLong);
        }
        (self.announced, self.have) = (bytes, 0);
        Ok(())
    }

    /// The next piece.
    ///
    /// # Errors
    /// [`Refusal::PatchPieces`]; the patch has to begin again then.
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

    /// All of it, once it has come.
    ///
    /// # Errors
    /// [`Refusal::PatchPieces`].
    pub fn whole(&self) -> Result<&[u8], Refusal> {
        if self.announced == 0 || self.have != self.announced {
            return Err(Refusal::PatchPieces);
        }
        bytemuck::cast_slice(&self.words).get(..self.have).ok_or(Refusal::PatchPieces)
    }
}
