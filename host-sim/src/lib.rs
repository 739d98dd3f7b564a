//! The command line `palpate`: it reads options, calls the crates below, writes results and prints
//! verdicts.
//!
//! ```text
//! command ─ tissue, loop ─ reports, charts
//!         └ fit, board; port (a board on a serial port): with the feature `full`
//! ```

// these macros tolerate a closed pipe
#[macro_use(eprintln, print, println)]
extern crate palpate_tissue;

use std::process::ExitCode;

use self::command::{Cli, Study};
use self::error::Error;

pub mod command;
mod contact_report;
pub mod error;
mod gltf;
mod loop_figures;
#[cfg(feature = "full")]
pub mod port;
mod press_report;
pub mod provenance;
mod section_report;
mod usda;
mod vtu;

/// Reads the command line, runs the command and reports an error in one line.
pub fn run() -> ExitCode {
    run_with(Cli::run)
}

/// Reads the command line and runs the study that it asks for, for a program that has the studies
/// and was built from this commit.
pub fn run_study(commit: &'static str, study: impl FnOnce(Study<'_>) -> Result<(), Error>) -> ExitCode {
    provenance::built_from(commit);
    run_with(|cli| cli.run_study(study))
}

fn run_with(run: impl FnOnce(&Cli) -> Result<(), Error>) -> ExitCode {
    let cli = match Cli::read() {
        Ok(cli) => cli,
        Err(error) if error.use_stderr() => {
            tell(&one_line(&error.to_string()));
            return ExitCode::from(2);
        }
        // clap prints help and version
        Err(error) => error.exit(),
    };
    match run(&cli) {
        Ok(()) if palpate_tissue::terminal::lost() => ExitCode::from(2),
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell(&error.to_string());
            ExitCode::from(error.exit_code())
        }
    }
}

/// Prints a message in one line, even if a name in it contains a line end.
fn tell(message: &str) {
    eprintln!("palpate: {}", message.replace(char::is_control, "\u{fffd}"));
}

/// Returns the error and the tip of clap's message on one line, without the usage that follows
/// them, and refers to the help.
fn one_line(message: &str) -> String {
    let lines = message.lines().map(str::trim).take_while(|l| !l.starts_with("Usage:") && !l.starts_with("For more information"));
    let said: Vec<&str> = lines.filter(|l| !l.is_empty()).collect();
    let said = said.join(" ");
    let said = said.trim_start_matches("error: ");
    // the help of a command that is gone would say so again
    match said {
        said if said.contains("is gone: ") => said.to_owned(),
        said if said.contains("invalid UTF-8") => "an argument is not text in UTF-8: rename the file".into(),
        said => format!("{said}: see --help"),
    }
}
