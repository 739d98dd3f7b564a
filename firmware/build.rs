//! Passes the linker its scripts and the image its patch. `[build] rustflags` has no effect if
//! `RUSTFLAGS` is set; link arguments from here always apply.

use core::error::Error;
use std::{
    env, fs,
    path::{Path, PathBuf},
    time::{SystemTime, UNIX_EPOCH},
};

/// Patch file that goes into the image; a relative path starts at the repository root.
const PATCH: &str = "PALPATE_PATCH";
const DEFAULT_PATCH: &str = "firmware/patches/block-m4f-168.patch";

#[path = "build/fingerprint.rs"]
mod fingerprint;
#[path = "build/memory.rs"]
mod memory;
#[path = "build/patch.rs"]
mod patch;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=../memory.x");
    for file in ["build.rs", "build/memory.rs", "build/patch.rs"] {
        println!("cargo:rerun-if-changed={file}");
    }
    println!("cargo:rustc-check-cfg=cfg(break_source, dma_streams)");
    let out = PathBuf::from(env::var("OUT_DIR")?);
    take_patch(&out)?;
    tell_day(&out)?;
    fingerprint::tell(&out)?;
    if env::var("CARGO_CFG_TARGET_OS")? != "none" {
        return Ok(());
    }
    let memory = match memory::of_chip() {
        Some(regions) => regions,
        None => {
            // cortex-m-rt includes this file for the names of interrupt handlers; a board whose
            // chip has no description here fills its vector table by itself
            fs::write(out.join("device.x"), "")?;
            memory::MPS2
        }
    };
    fs::copy("../memory.x", out.join("memory.x"))?;
    fs::write(out.join("regions.x"), memory.regions())?;
    fs::write(out.join("placement.x"), memory.placement())?;
    println!("cargo:rustc-link-search={}", out.display());
    for argument in ["-Tlink.x", "-Tdefmt.x", "--nmagic"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    Ok(())
}

/// Copies the patch to where `src/flash_patch.rs` includes it. The image checks its content when it
/// starts.
fn take_patch(out: &Path) -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-env-changed={PATCH}");
    let file = Path::new("..").join(env::var(PATCH).unwrap_or_else(|_| DEFAULT_PATCH.into()));
    println!("cargo:rerun-if-changed={}", file.display());
    let bytes = fs::read(&file)
        .map_err(|cause| format!("{PATCH}: {}: {cause}; pack one with `palpate pack --out firmware/patches`", file.display()))?;
    if env::var("CARGO_CFG_TARGET_OS")? == "none" {
        for (feature, _) in env::vars().filter(|(name, _)| name.starts_with("CARGO_FEATURE_")) {
            let board = feature.trim_start_matches("CARGO_FEATURE_").to_lowercase().replace('_', "-");
            patch::fits(&board, &bytes).map_err(|why| format!("{PATCH}: {}: {why}", file.display()))?;
        }
    }
    fs::write(out.join("packed.patch"), bytes)?;
    // the record of the patch's fit, from which hosts read its error; empty if there is none
    let mut name = file.into_os_string();
    name.push(".json");
    let record = match fs::read(&name) {
        Ok(record) => {
            println!("cargo:rerun-if-changed={}", Path::new(&name).display());
            record
        }
        Err(_) => Vec::new(),
    };
    fs::write(out.join("packed.patch.json"), record)?;
    Ok(())
}

/// Writes the day of the build, which hosts show, counted from 1970-01-01. For reproducible builds
/// `SOURCE_DATE_EPOCH` [s] replaces the clock.
fn tell_day(out: &Path) -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-env-changed=SOURCE_DATE_EPOCH");
    for folder in ["src", "controller/src", "../core/src"] {
        println!("cargo:rerun-if-changed={folder}");
    }
    let seconds = match env::var("SOURCE_DATE_EPOCH") {
        Ok(given) => given.parse::<u64>().map_err(|cause| format!("SOURCE_DATE_EPOCH: {given}: {cause}; give whole seconds"))?,
        Err(_) => SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs(),
    };
    let day = u16::try_from(seconds / 86_400)?;
    let text = format!("/// Day on which the image was built, counted from 1970-01-01.\nconst BUILT_DAY: u16 = {day};\n");
    Ok(fs::write(out.join("built_day.rs"), text)?)
}
