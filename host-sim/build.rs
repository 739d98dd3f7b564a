//! Tells the crate from which commit it is built, since results name the commit. `host-sim/lab`
//! is built by the same script.

use std::path::Path;
use std::process::Command;

/// Sources of the product on which a result depends, relative to the repository.
const SOURCES: [&str; 13] = [
    "Cargo.lock",
    "Cargo.toml",
    "core/Cargo.toml",
    "core/src",
    "firmware/controller/src",
    "host-sim/board/src",
    "host-sim/build.rs",
    "host-sim/charts/src",
    "host-sim/fit/src",
    "host-sim/loop/src",
    "host-sim/scenes",
    "host-sim/src",
    "host-sim/tissue/src",
];

fn main() {
    let folder = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default();
    let package = Path::new(&folder);
    println!("cargo::rerun-if-changed={}", package.join("src").display());
    let repository = package.ancestors().find(|folder| folder.join("rust-toolchain.toml").is_file());
    for path in SOURCES {
        if let Some(repository) = repository {
            println!("cargo::rerun-if-changed={}", repository.join(path).display());
        }
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
