//! The firmware's image in the emulator, driven in lock-step: the host sends one pose and receives
//! one record, and the same controller runs beside it on this machine.
//!
//! ```text
//! image ─ board ─ twin ─ press, campaign, in_loop, live_trace
//! ```
//!
//! `image` is built or given, `board` is the emulator and its link, and `twin` runs board and
//! desktop side by side and compares them to the bit. `press` (the finger), `campaign` (contact,
//! faults and recovery for any duration), `in_loop` (the closed loop's hands) and `live_trace` (a
//! recording of `palpate live`) run on it.
//!
//! Cost of a tick: `exec_log` (instructions executed), `firmware_image` (the functions to which
//! they belong), `thumb` (their classes), `instruction_mix` (cycles), `timing`; start times and
//! late ticks: `timed`; log of the image: `defmt_log`; errors of the fit of its patch:
//! `patch_record`.

pub mod board;
pub mod campaign;
pub mod defmt_log;
pub mod desktop_board;
pub mod exec_log;
pub mod firmware_image;
pub mod image;
pub mod in_loop;
pub mod instruction_mix;
pub mod live_trace;
pub mod one_core;
pub mod patch_record;
pub mod press;
pub mod thumb;
pub mod timed;
pub mod timing;
pub mod twin;

pub use board::{Board, EmulatedBoard};
pub use twin::{Difference, Lockstep};

use std::path::PathBuf;

use palpate_controller::link::{FrameError, Refusal};

/// Why the emulated board failed.
#[derive(Debug, thiserror::Error)]
pub enum EmulateError {
    /// A program is missing.
    #[error("{program} does not start: {source}; install it ({})", if *program == "cargo" { "https://rustup.rs" } else { "Debian: apt-get install qemu-system-arm" })]
    NotStarted {
        /// Name of the program.
        program: &'static str,
        /// I/O error of the operating system.
        source: std::io::Error,
    },
    /// The sources of the image are missing.
    #[error(
        "no firmware here: run it inside the repository, or give an image with --image FILE and, to `emulate`, a patch with --patch FILE"
    )]
    NoRepository,
    /// The firmware was not built.
    #[error("the firmware was not built; `cargo fw` says why: {0}")]
    NotBuilt(String),
    /// There is no image at that path.
    #[error("cannot read {0}: build one with `cargo fw`")]
    NoImage(PathBuf),
    /// There is no patch small enough for the board.
    #[error(
        "scene {0} has no patch for a board: give one with patch = \"FILE\" under [solver], or `emulate --patch FILE` (`palpate fit --board` and `palpate pack` make them)"
    )]
    NoPatch(String),
    /// The link to the emulated board broke.
    #[error("the link to the emulated board broke: {0}")]
    Link(#[from] std::io::Error),
    /// The board gives no answer.
    #[error("the emulated board does not answer (is the image one of `cargo fw`?); its last words: \"{0}\"")]
    Silent(String),
    /// A frame arrived damaged, which must not happen on a lock-step link.
    #[error("a frame of the board was dropped: {0}")]
    Frame(#[from] FrameError),
    /// The board refused the request.
    #[error("the board refuses: {0}")]
    Refused(Refusal),
    /// The trace asks for something that a board cannot do.
    #[error("the board cannot repeat this trace: {0}")]
    LiveTrace(String),
    /// Board and desktop differ.
    #[error("board and desktop part: {0}")]
    Differs(String),
    /// The board sent another answer than the expected one.
    #[error("the board answered out of turn: {0}")]
    OutOfTurn(String),
    /// The image cannot be read.
    #[error("{0}")]
    Image(#[from] firmware_image::ImageError),
    /// Executed instructions cannot be classified.
    #[error("{0}")]
    Mix(#[from] instruction_mix::MixError),
    /// The scene or the patch cannot be used on this machine.
    #[error("{0}")]
    Tissue(#[from] palpate_tissue::Error),
    /// This machine refuses the patch or the settings of the board.
    #[error("{0}")]
    Build(#[from] palpate::BuildError),
}
