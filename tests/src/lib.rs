//! Shared code of the tests: running the `palpate` command and reading its output; running the
//! firmware in the emulator, reading its image and counting its executed instructions; blocks of
//! tissue, an oracle of their forces in double precision, and the deviation from it that single
//! precision allows.
#![forbid(unsafe_code)]

pub use palpate_board::{exec_log, firmware_image, instruction_mix, thumb};

pub mod bench;
pub mod block_bound;
#[cfg(unix)]
pub mod board_on_a_port;
pub mod c_compiler;
pub mod case_ranges;
pub mod crash;
pub mod cube_mesh;
pub mod debugger;
pub mod disassembly;
pub mod emulator;
pub mod far_patch;
pub mod flash_patch;
pub mod free_handle;
pub mod indentation;
pub mod joint_hand;
pub mod mistakes;
pub mod oracle;
pub mod packed;
pub mod palpate_command;
pub mod pipeline_model;
pub mod press_run;
#[cfg(unix)]
pub mod pseudo_terminal;
pub mod register_model;
pub mod rounding;
pub mod schema;
pub mod share;
pub mod surface_text;
pub mod tap;
