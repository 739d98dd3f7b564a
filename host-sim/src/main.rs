//! `palpate`: see `palpate --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    palpate_sim::run()
}
