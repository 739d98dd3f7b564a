//! Placeholder for a command that this build does not contain. It accepts any arguments, since the
//! build that contains the command reads them.

use std::ffi::OsString;

use clap::Args;

use super::on_demand::build_and_run;
use crate::error::Error;

/// Arguments of a command of `palpate-full`.
#[derive(Args, Clone, Debug)]
pub(super) struct Absent {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    arguments: Vec<OsString>,
}

impl Absent {
    #[expect(clippy::unused_self, reason = "as every command's")]
    pub(super) fn run(&self) -> Result<(), Error> {
        build_and_run()
    }
}

pub(super) type AcceptArgs = Absent;
pub(super) type BoardCommand = Absent;
pub(super) type CalibrateArgs = Absent;
pub(super) type ChartArgs = Absent;
pub(super) type CutArgs = Absent;
pub(super) type EmulateArgs = Absent;
pub(super) type FitArgs = Absent;
pub(super) type PackArgs = Absent;
pub(super) type PaperCommand = Absent;
pub(super) type PlanArgs = Absent;
pub(super) type ReferenceArgs = Absent;
pub(super) type StabilityArgs = Absent;
