//! Command line of `palpate accept`.

use std::path::PathBuf;

use clap::Args;

use crate::command::campaign::CaseArgs;

/// Names of the tests.
pub const TESTS: [&str; 5] = ["T1", "T2", "T3", "T4", "T5"];

#[derive(Args, Clone, Debug)]
pub struct AcceptArgs {
    #[command(flatten)]
    pub options: AcceptOptions,
    /// Output folder, created if missing; a finished run replaces an earlier result in it.
    #[arg(long, value_name = "FOLDER", default_value = "out/accept")]
    pub out: PathBuf,
    #[command(flatten)]
    pub cases: CaseArgs,
}

/// The selected tests.
#[derive(Args, Clone, Debug)]
pub struct AcceptOptions {
    /// Run only these tests [default: all].
    #[arg(value_name = "TEST", value_parser = TESTS)]
    pub tests: Vec<String>,
}
