//! Reads the record of the fit of an image's patch from the image's ELF file.

use std::path::Path;

use object::{Object, ObjectSection};
use palpate_tissue::fit_record::FitRecord;

use super::defmt_log::checksum;

/// Section that contains the record; it is not loaded into the board's memory.
const SECTION: &str = ".palpate_record";

/// The record of the patch with checksum `patch`, from the file of the image that a board runs,
/// whose checksum the board reports as `image`. `None` if the file is another image, or has no
/// record of this patch.
#[must_use]
pub fn of_board(path: &Path, image: u32, patch: u32) -> Option<FitRecord> {
    let elf = std::fs::read(path).ok()?;
    if checksum(&elf) != Some(image) {
        return None;
    }
    let file = object::File::parse(&*elf).ok()?;
    let json = file.section_by_name(SECTION)?.data().ok()?;
    serde_json::from_slice(json).ok().filter(|record: &FitRecord| record.patch_crc32 == patch)
}
