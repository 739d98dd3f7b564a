//! Passes the cargo profile on to the crate; cargo itself gives build scripts only "debug" or
//! "release".

use std::path::Path;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // <target>/<profile>/build/<package>/out
    let out = std::env::var("OUT_DIR").unwrap_or_default();
    let profile = Path::new(&out).ancestors().nth(3).and_then(Path::file_name).and_then(|name| name.to_str());
    println!("cargo::rustc-env=PALPATE_PROFILE={}", profile.unwrap_or("unknown"));
}
