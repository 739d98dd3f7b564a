//! `palpate` with all commands but the studies.

use std::process::ExitCode;

fn main() -> ExitCode {
    palpate_sim::run()
}
