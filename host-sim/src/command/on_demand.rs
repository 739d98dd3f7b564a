//! Commands that this build does not hold: `palpate-full` holds them. It is built when one is first
//! asked for, and run with the same arguments.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use palpate_tissue::Error as TissueError;
use palpate_tissue::machine::PROFILE;

use super::tools::{Tools, run};
use crate::error::Error;

/// Builds `palpate-full` and runs it with the arguments of this process. Exits with its code.
pub(super) fn build_and_run() -> Result<(), Error> {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    if !package.join("Cargo.toml").is_file() {
        return Err(TissueError::Usage(format!(
            "this build of palpate lacks this command, and {} is not there to build it from: build palpate with `--features full`",
            package.display()
        ))
        .into());
    }
    eprintln!("building palpate-full, which has this command; the first time takes some minutes");
    let started = Instant::now();
    let profile = if PROFILE == "debug" { "dev" } else { PROFILE };
    let build = ["--quiet", "--profile", profile, "--package", "palpate-sim", "--bin", "palpate-full", "--features", "full"];
    let full = Tools::in_use(package.to_path_buf()).build(&build, "palpate-full")?;
    eprintln!("built in {:.0} s", started.elapsed().as_secs_f64());
    let status = run(Command::new(&full).args(std::env::args_os().skip(1)), &full.display().to_string())?;
    std::process::exit(status.code().unwrap_or(2))
}
