//! The patch in the image's flash.

use palpate_controller::patch::WordAligned;

/// The file that `PALPATE_PATCH` named when the image was built.
static PATCH_FILE: &WordAligned<[u8]> = &WordAligned(*include_bytes!(concat!(env!("OUT_DIR"), "/packed.patch")));

/// The packed patch in flash.
pub fn in_flash() -> &'static [u8] {
    &PATCH_FILE.0
}
