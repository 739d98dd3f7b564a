//! The command line.

mod mesh;
mod press;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::error::Error;

/// Soft tissue for haptic devices: press it, measure it, pack it for a board.
///
/// Without a command: presses the default block. Every command writes summary.json, CSV tables and pictures (SVG and PNG) into its output
/// folder, and exits with 0 if what it promises held, 1 if a check failed, 2 on bad input.
#[derive(Debug, Parser)]
#[command(name = "palpate", version, max_term_width = 110)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Press a scene at 1 kHz in virtual time: force-depth curve, tick times, trace, picture of the dent.
    Press(press::PressArgs),
    /// Check a mesh file, or pack a scene's patch for a board.
    #[command(subcommand)]
    Mesh(mesh::MeshCommand),
}

/// What most commands take.
#[derive(Args, Clone, Debug)]
struct Common {
    /// A preset (block, block-deep, block-20kpa, nodule, liver) or the path of a scene file.
    #[arg(long, default_value = "block")]
    scene: String,
    /// Output folder [default: out/<command>].
    #[arg(long)]
    out: Option<PathBuf>,
}

impl Common {
    fn folder(&self, command: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| PathBuf::from("out").join(command))
    }
}

impl Cli {
    /// Runs the command.
    ///
    /// # Errors
    /// Bad input or a failed check; [`Error::exit_code`] tells which.
    pub fn run(&self) -> Result<(), Error> {
        match &self.command {
            None => press::PressArgs::default().run(),
            Some(Command::Press(args)) => args.run(),
            Some(Command::Mesh(command)) => command.run(),
        }
    }
}
