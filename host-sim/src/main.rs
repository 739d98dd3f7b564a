//! `palpate`: see `palpate --help`.

use std::process::ExitCode;

use clap::Parser;
use palpate_sim::command::Cli;

fn main() -> ExitCode {
    match Cli::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("palpate: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
