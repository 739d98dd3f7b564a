//! Tells the crate which commit it is built from: results say so.

use std::process::Command;

/// Sources that decide a result, from this folder.
const SOURCES: [&str; 14] = [
    "../Cargo.lock",
    "../Cargo.toml",
    "../core/Cargo.toml",
    "../core/src",
    "../firmware/controller/src",
    "board/src",
    "charts/src",
    "fit/src",
    "lab/src",
    "loop/src",
    "scenes",
    "src",
    "tissue/src",
    "build.rs",
];

fn main() {
    for path in SOURCES {
        println!("cargo::rerun-if-changed={path}");
    }
    // a commit moves one of these; in a work tree they are elsewhere
    for name in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&["rev-parse", "--git-path", name]) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    // outside a repository there is no commit, and results say that
    let commit = git(&["describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]);
    println!("cargo::rustc-env=PALPATE_COMMIT={}", commit.unwrap_or_default());
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    (output.status.success() && !text.trim().is_empty()).then(|| text.trim().to_owned())
}
