//! The built `palpate-full`, or for the tests of `host-sim/lab` the built `palpate-lab`. Tests run
//! it as a user would, by its command line in any folder, and check its output and files.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use crate::schema;

/// A user's working folder: empty at first, deleted when dropped.
#[derive(Debug)]
pub struct Desk(tempfile::TempDir);

/// Exit code and output of a command.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Exit code; `None` if a signal ended the command.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error without the progress lines that a command prints every ten seconds, since
    /// their number depends on the machine.
    pub stderr: String,
}

/// Root folder of the repository.
///
/// # Panics
/// Panics if the tests are not in a repository.
pub fn repository() -> &'static Path {
    let ancestors = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    ancestors.into_iter().find(|folder| folder.join("rust-toolchain.toml").is_file()).expect("the tests are in the repository")
}

/// Files below folders of the repository whose names end with `end`, in order; without hidden
/// folders and what was built.
pub fn files_below(folders: &[&str], end: &str) -> Vec<PathBuf> {
    let (mut folders, mut files) = (folders.iter().map(|f| repository().join(f)).collect::<Vec<_>>(), Vec::new());
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if path.is_dir() && !name.starts_with('.') && !["target", "out"].contains(&&*name) {
                folders.push(path);
            } else if path.is_file() && name.ends_with(end) {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// Path of the program; builds `palpate-full` once. `scratch` is the test's `CARGO_TARGET_TMPDIR`,
/// in cargo's target directory.
///
/// # Panics
/// Panics if it cannot be built.
pub fn binary(scratch: &str) -> &'static Path {
    // cargo has built it for the tests of its own package
    if let Some(lab) = option_env!("CARGO_BIN_EXE_palpate-lab") {
        return Path::new(lab);
    }
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    BUILT.get_or_init(|| {
        let target = Path::new(scratch).parent().expect("cargo keeps its scratch folder in the target directory");
        let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
        let build = Command::new(cargo)
            .args([
                "build",
                "--release",
                "--package",
                "palpate-sim",
                "--features",
                "full",
                "--bin",
                "palpate-full",
                "--target-dir",
            ])
            .arg(target)
            .current_dir(repository())
            .output()
            .expect("cargo runs this test, so it starts");
        assert!(build.status.success(), "palpate was not built:\n{}", String::from_utf8_lossy(&build.stderr));
        target.join("release/palpate-full")
    })
}

/// Runs `palpate` in a folder and checks that every summary that it writes there follows the
/// schema. `scratch` is `env!("CARGO_TARGET_TMPDIR")`.
///
/// # Panics
/// Panics if a summary does not follow the schema.
pub fn palpate(scratch: &str, folder: &Path, arguments: &[&str]) -> Outcome {
    let output = Command::new(binary(scratch))
        .args(arguments)
        .current_dir(folder)
        .env("RUST_BACKTRACE", "1")
        // a fixed date, because two runs are compared byte for byte
        .env("SOURCE_DATE_EPOCH", "0")
        .output()
        .expect("palpate was just built");
    let after_out = arguments.iter().position(|argument| *argument == "--out").and_then(|at| arguments.get(at + 1));
    schema::check_all(&folder.join(after_out.unwrap_or(&"out")));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let stderr = text(&output.stderr).split_inclusive('\n').filter(|line| !is_progress(line)).collect();
    Outcome { code: output.status.code(), stdout: text(&output.stdout), stderr }
}

/// Runs a command that must be refused with one line that contains all of `says`.
///
/// # Panics
/// It is not.
#[track_caller]
pub fn refused(scratch: &str, desk: &Desk, arguments: &[&str], says: &[&str]) {
    let before = desk.listing();
    let outcome = palpate(scratch, desk.folder(), arguments);
    let message = format!("{arguments:?}: {outcome:?}");
    assert_eq!(outcome.code, Some(2), "{message}");
    assert!(outcome.stderr.starts_with("palpate: ") && outcome.stderr.ends_with('\n'), "{message}");
    assert_eq!(outcome.stderr.lines().count(), 1, "{message}");
    for words in says {
        assert!(outcome.stderr.contains(words), "not a word of `{words}`\n{message}");
    }
    for noise in ["panicked", "backtrace", "src/", "Error {", "Some("] {
        assert!(!outcome.stderr.contains(noise), "{message}");
    }
    assert_eq!(outcome.stdout, "", "{message}");
    assert_eq!(desk.listing(), before, "{message}");
}

/// Whether a line reports progress outside a terminal, such as "after 20 s: mesh 2 of 3". Errors
/// begin with the program's name.
#[must_use]
pub fn is_progress(line: &str) -> bool {
    let seconds = |rest: &str| {
        let after_digits = rest.trim_start_matches(|c: char| c.is_ascii_digit());
        after_digits.len() < rest.len() && after_digits.starts_with(" s")
    };
    !line.starts_with("palpate") && line.split("after ").skip(1).any(seconds)
}

impl Default for Desk {
    fn default() -> Self {
        Self(tempfile::tempdir().expect("the system has a temporary folder"))
    }
}

impl Desk {
    /// Path of the folder.
    pub fn folder(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file into the folder.
    pub fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.0.path().join(name), content).expect("a temporary folder can be written");
    }

    /// Names of everything in the folder, sorted.
    pub fn listing(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("a temporary folder can be read");
        let mut names: Vec<_> = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

#[cfg(test)]
mod tests {
    use super::is_progress;

    #[test]
    fn progress_is_told_from_errors() {
        for line in
            ["after 11 s: mesh 2 of 3, 0.50 mm deep\n", "3 of 12 presses after 20 s\n", "fit: 3 of 12 after 20 s, press 3\n"]
        {
            assert!(is_progress(line), "{line}");
        }
        for line in ["palpate: no answer after 2 s\n", "the force has none after 140 ms\n", "named after somebody\n"] {
            assert!(!is_progress(line), "{line}");
        }
    }
}
