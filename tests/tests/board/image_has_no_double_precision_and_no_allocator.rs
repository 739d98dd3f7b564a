//! The image computes in single precision and allocates nothing.

use std::path::Path;

use palpate_tests::{emulator::build_firmware, firmware_image::FirmwareImage};

/// Whether a symbol is a double-precision routine: a name of the run-time ABI (Arm IHI 0043), its
/// libgcc alias, or an internal routine of libm.
fn is_double_precision(name: &str) -> bool {
    const PREFIXES: [&str; 4] = ["__aeabi_d", "__aeabi_f2d", "__aeabi_i2d", "__aeabi_ui2d"];
    let abi = PREFIXES.iter().any(|p| name.starts_with(p)) && !name.starts_with("__aeabi_div0");
    let gcc = name.starts_with("__") && name.contains("df") && name.ends_with(['2', '3', 'f', 'i']);
    abi || gcc || name.contains("float::div::__divdf") || name.contains("libm::math") && name.contains("f64")
}

/// Whether a symbol belongs to an allocator. `alloc::` is the crate's path, so it counts only at
/// the start of a path or after `<`, not within a longer word.
fn is_of_an_allocator(name: &str) -> bool {
    const NAMES: [&str; 8] =
        ["__rust_alloc", "__rust_dealloc", "__rust_realloc", "__rustc::__rust", "__rg_alloc", "malloc", "realloc", "alloc::"];
    NAMES.iter().any(|bad| name.starts_with(bad) || name.contains(&format!("<{bad}")))
}

#[test]
fn image_has_no_double_precision_and_no_allocator() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let elf = build_firmware(target, &[]).unwrap();
    let image = FirmwareImage::parse(&std::fs::read(elf).unwrap()).unwrap();
    assert!(image.symbols().count() > 20, "a stripped image proves nothing");
    assert_eq!(image.symbols().filter(|name| is_double_precision(name)).collect::<Vec<_>>(), [""; 0]);
    assert_eq!(image.symbols().filter(|name| is_of_an_allocator(name)).collect::<Vec<_>>(), [""; 0]);
}

#[test]
fn double_precision_is_recognised_and_integer_division_is_not() {
    let symbols = ["__aeabi_dadd", "__aeabi_f2d", "__muldf3", "__truncdfsf2", "__aeabi_uidiv", "__udivmoddi4", "sqrtf"];
    let found: Vec<_> = symbols.into_iter().filter(|name| is_double_precision(name)).collect();
    assert_eq!(found, ["__aeabi_dadd", "__aeabi_f2d", "__muldf3", "__truncdfsf2"]);
}

#[test]
fn an_allocator_is_recognised() {
    let symbols = [
        "__rust_alloc",
        "alloc::raw_vec::finish_grow",
        "<alloc::string::String>::push",
        "core::fmt::write",
        "heapless::pool::alloc_one",
    ];
    let found: Vec<_> = symbols.into_iter().filter(|name| is_of_an_allocator(name)).collect();
    assert_eq!(found, symbols[..3]);
}
