//! The default patch of the image.

use palpate_controller::patch::WordAligned;

static PATCH_FILE: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../firmware/patches/block-m4f-168.patch"));

/// The image's packed default patch, as it is stored in flash.
pub fn in_flash() -> &'static [u8] {
    &PATCH_FILE.0
}
