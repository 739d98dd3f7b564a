//! Commands that only `palpate-full` executes.

use super::on_demand::{Program, build_and_run};
use super::options::board::BoardCommand;
use super::options::calibrate::CalibrateArgs;
use super::options::cut::CutArgs;
use super::options::emulate::EmulateArgs;
use super::options::fit::FitArgs;
use super::options::pack::PackArgs;
use super::options::plan::PlanArgs;
use super::options::reference::ReferenceArgs;
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
absent!(BoardCommand, CalibrateArgs, CutArgs, EmulateArgs, FitArgs, PackArgs, PlanArgs, ReferenceArgs);
