//! The command `palpate completions`.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{Cli, help};
use crate::error::Error;

#[derive(Args, Clone, Debug)]
pub(super) struct CompletionsArgs {
    /// Shell for which the script is written.
    #[arg(value_enum)]
    shell: Shell,
}

impl CompletionsArgs {
    #[expect(clippy::unnecessary_wraps, reason = "as every command's")]
    pub(super) fn run(&self) -> Result<(), Error> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut help::grouped(Cli::command()), "palpate", &mut script);
        print!("{}", String::from_utf8_lossy(&script));
        Ok(())
    }
}
