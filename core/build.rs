//! Tells the crate whether its target has the instructions of a Cortex-M4F: `cfg(armv7em_fp)`. No
//! `cfg` of the compiler distinguishes it from a Cortex-M33, which may lack some of them: the
//! feature `cortex-m33` says that it has them.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(armv7em_fp)");
    let m33 = std::env::var_os("CARGO_FEATURE_CORTEX_M33").is_some();
    let processor = match std::env::var("TARGET").unwrap_or_default().as_str() {
        "thumbv7em-none-eabihf" => ".fpu fpv4-sp-d16",
        "thumbv8m.main-none-eabihf" if m33 => ".cpu cortex-m33",
        _ => return,
    };
    println!("cargo::rustc-cfg=armv7em_fp");
    println!("cargo::rustc-env=PALPATE_PROCESSOR={processor}");
}
