//! Checksums of the files that a campaign reads.

use std::path::Path;

use super::checksum;
use crate::error::Error;
use crate::scene::{PRESETS, Scene};

/// Checksum of a scene's file and of the files that it names; `None` for a preset, which ships with
/// the program.
///
/// # Errors
/// The scene's file cannot be read. For a scene with errors or missing files, the checksum is that
/// of its own file.
pub fn scene_checksum(name_or_path: &str) -> Result<Option<String>, Error> {
    if PRESETS.iter().any(|(name, _)| *name == name_or_path) {
        return Ok(None);
    }
    let read = |path: &Path| std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source });
    let mut bytes = read(Path::new(name_or_path))?;
    if let Ok(scene) = Scene::load(name_or_path) {
        for file in scene.files() {
            bytes.extend(read(file).unwrap_or_default());
        }
    }
    Ok(Some(checksum(&bytes)))
}
