//! Tells the crate whether its target has the instructions of a Cortex-M4F: `cfg(armv7em_fp)`. No
//! `cfg` of the compiler distinguishes it from a Cortex-M33, which may lack some of them.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(armv7em_fp)");
    let target = std::env::var("TARGET").unwrap_or_default();
    if target.starts_with("thumbv7em-none-eabihf") {
        println!("cargo::rustc-cfg=armv7em_fp");
    }
}
