//! Finds or builds the firmware's image, and finds the patch for a board.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::{EmulateError, EmulatedBoard};
use palpate_tissue::scene::Scene;

/// End of the file names of patches for the larger board.
const LARGE: &str = "m7-480.patch";

/// Finds the repository that contains the working folder.
///
/// # Errors
/// Fails with [`EmulateError::NoRepository`] if the working folder is not in the repository.
pub fn repository() -> Result<PathBuf, EmulateError> {
    let here = std::env::current_dir().map_err(|_| EmulateError::NoRepository)?;
    let is_root = |path: &&Path| path.join("firmware/Cargo.toml").is_file() && path.join("memory.x").is_file();
    here.ancestors().find(is_root).map(Path::to_path_buf).ok_or(EmulateError::NoRepository)
}

/// Builds the image with `cargo fw` in the repository that contains the working folder.
///
/// # Errors
/// There is no repository or no cargo, or the firmware does not compile.
pub fn build() -> Result<PathBuf, EmulateError> {
    build_with(None)
}

/// Builds the image as [`build`] does; a patch that is given replaces the one in its flash.
///
/// # Errors
/// Errors of [`build`].
pub fn build_with(patch: Option<&Path>) -> Result<PathBuf, EmulateError> {
    let root = repository()?;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    match patch {
        Some(patch) => command.env("PALPATE_PATCH", patch),
        None => command.env_remove("PALPATE_PATCH"),
    };
    let output = command
        .args(["fw", "--quiet", "--message-format", "json-render-diagnostics"])
        .current_dir(root)
        .output()
        .map_err(|source| EmulateError::NotStarted { program: "cargo", source })?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        // the build script's own error is beside cargo's
        let starts = |with: &str| text.lines().map(str::trim_start).find(|line| line.starts_with(with));
        let first = starts("Error: ").or_else(|| starts("error")).unwrap_or("cargo failed");
        return Err(EmulateError::NotBuilt(first.to_owned()));
    }
    let messages = String::from_utf8_lossy(&output.stdout);
    let mut executable = messages.lines().filter_map(|line| {
        let message: serde_json::Value = serde_json::from_str(line).ok()?;
        message.get("executable")?.as_str().map(PathBuf::from)
    });
    executable.next_back().ok_or_else(|| EmulateError::NotBuilt("cargo named no image".into()))
}

/// Finds the image to run: the one given, or else a newly built one.
///
/// # Errors
/// Errors of [`build`], or no file at the given path.
pub fn find(given: Option<&Path>) -> Result<PathBuf, EmulateError> {
    match given {
        Some(path) if path.is_file() => Ok(path.into()),
        Some(path) => Err(EmulateError::NoImage(path.into())),
        None => build(),
    }
}

/// Finds the patch that represents a scene on a board: the scene's own, or a shipped one.
///
/// # Errors
/// There is no such patch, or no repository that contains it.
pub fn patch_for(scene: &Scene) -> Result<PathBuf, EmulateError> {
    if let Some(path) = &scene.solver.patch {
        return Ok(path.clone());
    }
    let name = match scene {
        // a small patch has no nodes where its nodule is
        Scene { name, tissue, .. } if name == "nodule" && !tissue.inclusion.is_empty() => "nodule-m7-480.patch",
        Scene { tissue, .. } if tissue.block_m.is_some() && tissue.inclusion.is_empty() => "block-m4f-168.patch",
        Scene { name, .. } if name.contains("liver") => "liver-m4f-168.patch",
        _ => return Err(EmulateError::NoPatch(scene.name.clone())),
    };
    Ok(repository()?.join(Path::new("firmware/patches").join(name)))
}

/// The board for which a patch is made, by the name of its file.
#[must_use]
pub fn machine_for(patch: &Path) -> EmulatedBoard {
    if patch.file_name().is_some_and(|name| name.to_string_lossy().ends_with(LARGE)) {
        EmulatedBoard::M7
    } else {
        EmulatedBoard::M4f
    }
}
