//! `palpate` with all commands.

use std::process::ExitCode;

fn main() -> ExitCode {
    palpate_sim::run()
}
