//! A copy of the mutated packages, with its own workspace and build folder.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::list::Mutant;

/// Folders and files from which the two packages are built.
const PARTS: [&str; 11] = [
    "core/Cargo.toml",
    "core/build.rs",
    "core/examples",
    "core/src",
    "core/tests/fast",
    "firmware",
    "memory.x",
    "Cargo.lock",
    "rust-toolchain.toml",
    "clippy.toml",
    ".cargo/mutants.toml",
];

/// A copy under the repository's build folder.
pub struct Copy {
    /// Root folder of the copy.
    pub root: PathBuf,
}

impl Copy {
    /// Updates the copy in `root` from the sources in `from` and keeps earlier build output.
    pub fn make(from: &Path, root: PathBuf) -> Result<Self, String> {
        for part in PARTS {
            let (from, to) = (from.join(part), root.join(part));
            take(&from, &to)?;
        }
        let manifest = from.join("Cargo.toml");
        let text = fs::read_to_string(&manifest).map_err(|error| named(&manifest, &error))?;
        let to = root.join("Cargo.toml");
        write_changed(&to, two_packages(&text)?.as_bytes()).map_err(|error| named(&to, &error))?;
        Ok(Self { root })
    }

    /// Applies the mistake to the copy, runs `judge`, and restores the files.
    pub fn with<T>(&self, mutant: &Mutant, judge: impl FnOnce(&Self) -> T) -> Result<T, String> {
        let mut before = Vec::new();
        let mut changed = Ok(());
        for edit in &mutant.edit {
            let path = self.root.join(&edit.file);
            let content = fs::read_to_string(&path).map_err(|error| named(&path, &error))?;
            changed = edit.apply(&content).and_then(|text| fs::write(&path, text).map_err(|error| named(&path, &error)));
            before.push((path, content));
            if changed.is_err() {
                break;
            }
        }
        let answer = changed.map(|()| judge(self));
        // edits are undone in reverse order, since two may be in one file
        for (path, content) in before.into_iter().rev() {
            fs::write(&path, content).map_err(|error| named(&path, &error))?;
        }
        answer
    }
}

/// The workspace's manifest, reduced to the two packages.
fn two_packages(text: &str) -> Result<String, String> {
    let mut manifest: toml::Table = toml::from_str(text).map_err(|error| format!("Cargo.toml: {error}"))?;
    let workspace = manifest.get_mut("workspace").and_then(toml::Value::as_table_mut).ok_or("Cargo.toml: no workspace")?;
    workspace.insert("members".into(), vec!["core".to_owned(), "firmware/controller".to_owned()].into());
    workspace.remove("default-members");
    workspace.remove("exclude");
    if let Some(dependencies) = workspace.get_mut("dependencies").and_then(toml::Value::as_table_mut) {
        dependencies.retain(|name, value| name == "palpate" || value.get("path").is_none());
    }
    toml::to_string(&manifest).map_err(|error| format!("Cargo.toml: {error}"))
}

/// Copies a file or a folder and removes files that no longer exist in the source. Unchanged files
/// keep their modification time, so that they are not rebuilt.
fn take(from: &Path, to: &Path) -> Result<(), String> {
    if from.is_dir() {
        for old in fs::read_dir(to).into_iter().flatten().flatten() {
            let (gone, old) = (!from.join(old.file_name()).exists(), old.path());
            if gone {
                let removed = if old.is_dir() { fs::remove_dir_all(&old) } else { fs::remove_file(&old) };
                removed.map_err(|error| named(&old, &error))?;
            }
        }
        for entry in fs::read_dir(from).map_err(|error| named(from, &error))? {
            let entry = entry.map_err(|error| named(from, &error))?;
            take(&entry.path(), &to.join(entry.file_name()))?;
        }
        return Ok(());
    }
    let content = fs::read(from).map_err(|error| named(from, &error))?;
    write_changed(to, &content).map_err(|error| named(to, &error))
}

fn write_changed(to: &Path, content: &[u8]) -> io::Result<()> {
    if fs::read(to).is_ok_and(|old| old == content) {
        return Ok(());
    }
    to.parent().map_or(Ok(()), fs::create_dir_all)?;
    fs::write(to, content)
}

fn named(path: &Path, error: &io::Error) -> String {
    format!("{}: {error}", path.display())
}
