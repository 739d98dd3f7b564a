//! The patch that a board opens next.

use crate::link::{Change, Refusal, Upload};

/// Memory in which the patch is stored.
#[derive(Clone, Copy)]
enum Source {
    Flash,
    Uploaded,
    /// There is no patch: it is being uploaded, or was refused.
    Nowhere,
}

/// The patch that is opened next.
pub(super) struct Offer {
    source: Source,
    /// Young's modulus [Pa]; `None` for the one in the patch file.
    pub(super) modulus_pa: Option<f32>,
    /// The modulus to return to when another one is refused.
    before_pa: Option<f32>,
    /// Whether this patch was opened successfully with the modulus in `before_pa`.
    opened: bool,
    /// Whether the host requested the patch and waits for an answer.
    pub(super) asked: bool,
}

impl Offer {
    /// The patch that is built into the image.
    pub(super) const IN_FLASH: Self =
        Self { source: Source::Flash, modulus_pa: None, before_pa: None, opened: false, asked: false };

    /// The bytes of the patch; `None` while there is none.
    pub(super) fn bytes<'a>(&self, in_flash: &'a [u8], upload: &'a Upload) -> Result<Option<&'a [u8]>, Refusal> {
        match self.source {
            Source::Flash => Ok(Some(in_flash)),
            Source::Uploaded => upload.whole().map(Some),
            Source::Nowhere => Ok(None),
        }
    }

    /// Sets the patch that the host wants as the next one.
    pub(super) fn change(&mut self, change: Change, upload: &mut Upload) -> Result<(), Refusal> {
        match change {
            Change::MakeRoom(bytes) => {
                upload.begin(bytes)?;
                (self.source, self.modulus_pa) = (Source::Nowhere, None);
            }
            Change::Take => (self.source, self.opened, self.asked) = (Source::Uploaded, false, true),
            Change::Modulus(pascal) => (self.modulus_pa, self.asked) = (Some(pascal), true),
        }
        Ok(())
    }

    /// Records that the patch has been opened with `modulus_pa`.
    pub(super) fn taken(&mut self) {
        (self.before_pa, self.opened) = (self.modulus_pa, true);
    }

    /// Handles a refusal: returns to the previous modulus, if this patch was open with it.
    /// Otherwise there is no patch, and arming is refused.
    pub(super) fn withdraw(&mut self) {
        if self.opened {
            (self.modulus_pa, self.opened) = (self.before_pa, false);
        } else {
            self.source = Source::Nowhere;
        }
    }
}
