//! Command lines of the commands that another program executes: `palpate` reads them, prints their
//! help and refuses what is wrong with them before anything is built.
#![allow(missing_docs)] // reason: the comment of a field is its help, and a group of options has none

pub mod accept;
pub mod board;
pub mod chart;
pub mod emulate;
pub mod faults;
pub mod fit;
pub mod identify;
pub mod pack;
pub mod paper;
pub mod stability;
pub mod suite;
pub mod unseen;

use clap::ValueEnum;

/// An emulated board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EmulatedBoard {
    /// Cortex-M4F (MPS2 with image AN386).
    #[value(name = "m4f-168", alias = "m4f")]
    M4f,
    /// Cortex-M7 (MPS2 with image AN500).
    #[value(name = "m7-480", alias = "m7")]
    M7,
}

impl EmulatedBoard {
    /// Name on the command line: that of the budget whose patches the board runs.
    pub fn name(self) -> &'static str {
        match self {
            Self::M4f => "m4f-168",
            Self::M7 => "m7-480",
        }
    }
}

#[cfg(feature = "full")]
impl From<EmulatedBoard> for palpate_board::EmulatedBoard {
    fn from(board: EmulatedBoard) -> Self {
        match board {
            EmulatedBoard::M4f => Self::M4f,
            EmulatedBoard::M7 => Self::M7,
        }
    }
}
