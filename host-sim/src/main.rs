//! `palpate`: see `palpate --help`.

use std::process::ExitCode;

use clap::Parser;
use palpate_sim::command::Cli;

fn main() -> ExitCode {
    match Cli::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // a name in the message may hold a line end; the message stays one line
            eprintln!("palpate: {}", error.to_string().replace(char::is_control, "\u{fffd}"));
            ExitCode::from(error.exit_code())
        }
    }
}
