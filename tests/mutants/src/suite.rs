//! Runs the fast tests of a package in the copy of the sources.

use std::fmt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::copy::Copy;
use crate::list::Mutant;

/// Result of the suite for one mistake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// At least one test failed.
    Noticed,
    /// The tests did not end within the time limit.
    Endless,
    /// Every test passed.
    Survived,
    /// The compiler rejected the mistake, which says nothing about the tests.
    Unbuilt,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Noticed => "noticed",
            Self::Endless => "noticed: the tests did not end",
            Self::Survived => "survived",
            Self::Unbuilt => "does not build",
        })
    }
}

/// Packages that contain the given mistakes.
pub fn packages(mutants: &[Mutant]) -> Vec<&'static str> {
    ["palpate", "palpate-controller"].into_iter().filter(|package| mutants.iter().any(|m| m.package() == *package)).collect()
}

/// Builds the package's tests and runs them.
pub fn judge(copy: &Copy, package: &str, longest: Duration) -> Result<Verdict, String> {
    if !end(cargo(copy, package, &["--no-run"])?, Duration::MAX)?.unwrap_or(false) {
        return Ok(Verdict::Unbuilt);
    }
    Ok(match end(cargo(copy, package, &[])?, longest)? {
        Some(true) => Verdict::Survived,
        Some(false) => Verdict::Noticed,
        None => Verdict::Endless,
    })
}

fn cargo(copy: &Copy, package: &str, options: &[&str]) -> Result<Child, String> {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(["test", "--quiet", "--profile", "mutants", "--package", package, "--lib", "--tests"]).args(options);
    // the tips that only desktops have are tested as well
    command.args(["--features", "palpate/long-tips"]);
    command.current_dir(&copy.root).env("CARGO_TARGET_DIR", copy.root.join("../build")).env("RUST_BACKTRACE", "0");
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    // its own process group, so that an endless test program is stopped together with its cargo
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command.spawn().map_err(|error| format!("cargo: {error}"))
}

/// Returns whether the process succeeded; `None` if it exceeded the time limit and was killed.
fn end(mut child: Child, longest: Duration) -> Result<Option<bool>, String> {
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait().map_err(|error| format!("cargo: {error}"))? {
            return Ok(Some(status.success()));
        }
        if started.elapsed() > longest {
            _ = Command::new("kill").args(["-KILL", "--", &format!("-{}", child.id())]).status();
            _ = child.wait();
            return Ok(None);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}
