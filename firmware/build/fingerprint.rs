//! A checksum of all sources and settings that determine an image's log. Hosts compare the checksum
//! that a board reports with the one in an ELF file.

use core::error::Error;
use std::{
    env, fs,
    path::{Path, PathBuf},
};

/// Sources of the image, relative to this package.
const SOURCES: [&str; 8] =
    ["src", "controller/src", "../core/src", "build", "build.rs", "Cargo.toml", "../Cargo.lock", "../rust-toolchain.toml"];
/// Environment variable that sets the level of the log.
const LEVEL: &str = "DEFMT_LOG";

/// Writes the checksum as a constant.
pub fn tell(out: &Path) -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-env-changed={LEVEL}");
    let mut files = Vec::new();
    for source in SOURCES {
        println!("cargo:rerun-if-changed={source}");
        gather(Path::new(source), &mut files)?;
    }
    files.sort();
    let mut features: Vec<String> = env::vars().map(|(name, _)| name).filter(|name| name.starts_with("CARGO_FEATURE_")).collect();
    features.sort();
    features.extend([env::var("TARGET")?, env::var(LEVEL).unwrap_or_default()]);
    // FNV-1a
    let mut hash = 0x811C_9DC5_u32;
    let mut add = |bytes: &[u8]| bytes.iter().for_each(|byte| hash = (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193));
    features.iter().for_each(|word| add(word.as_bytes()));
    for file in files {
        add(file.to_string_lossy().replace('\\', "/").as_bytes());
        add(&fs::read(&file)?);
    }
    let text = format!("/// Checksum of sources and features.\nconst IMAGE: u32 = {:#x};\n", hash.max(1));
    Ok(fs::write(out.join("image.rs"), text)?)
}

fn gather(path: &Path, files: &mut Vec<PathBuf>) -> Result<(), Box<dyn Error>> {
    if !path.is_dir() {
        files.push(path.into());
        return Ok(());
    }
    for entry in fs::read_dir(path)? {
        gather(&entry?.path(), files)?;
    }
    Ok(())
}
