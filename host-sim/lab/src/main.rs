//! `palpate-lab`: the studies of `palpate`, which builds and starts this program.

use std::process::ExitCode;

fn main() -> ExitCode {
    palpate_sim::run_study(env!("PALPATE_COMMIT"), palpate_lab::command::run)
}
