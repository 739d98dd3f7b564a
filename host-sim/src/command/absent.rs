//! Commands that only `palpate-full` executes.

use super::on_demand::{Program, build_and_run};
use super::options::board::BoardCommand;
use super::options::emulate::EmulateArgs;
use super::options::fit::FitArgs;
use super::options::identify::IdentifyArgs;
use super::options::pack::PackArgs;
use crate::error::Error;

macro_rules! absent {
    ($($command:ty),*) => {
        $(impl $command {
            pub(super) fn run(&self) -> Result<(), Error> {
                build_and_run(Program::Full)
            }
        })*
    };
}
absent!(BoardCommand, EmulateArgs, FitArgs, IdentifyArgs, PackArgs);
