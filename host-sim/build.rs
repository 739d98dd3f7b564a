//! Tells the crate from which commit it is built, since results name the commit.

use std::process::Command;

/// Sources on which a result depends, relative to this folder.
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
    // a commit changes one of these files; in a work tree they are in another folder
    for name in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&["rev-parse", "--git-path", name]) {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    // outside a repository there is no commit, and results say so
    let commit = git(&["describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]);
    println!("cargo::rustc-env=PALPATE_COMMIT={}", commit.unwrap_or_default());
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    (output.status.success() && !text.trim().is_empty()).then(|| text.trim().to_owned())
}
