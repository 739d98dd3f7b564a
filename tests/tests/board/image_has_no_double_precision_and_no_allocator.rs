//! The image computes in single precision and allocates nothing.

use std::path::Path;

use palpate_tests::{emulator::build_firmware, firmware_image::FirmwareImage};

#[test]
fn image_has_no_double_precision_and_no_allocator() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let elf = build_firmware(target, &[]).unwrap();
    let image = FirmwareImage::parse(&std::fs::read(elf).unwrap()).unwrap();
    assert!(image.functions().len() > 20, "a stripped image proves nothing");
    assert_eq!(image.double_precision_symbols().collect::<Vec<_>>(), [""; 0]);
    assert_eq!(image.allocator_symbols().collect::<Vec<_>>(), [""; 0]);
}
