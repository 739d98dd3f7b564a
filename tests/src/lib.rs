//! What the on-target tests share: running the firmware in the emulator, reading its image, counting what it executed.
#![forbid(unsafe_code)]

pub mod disassembly;
pub mod emulator;
pub mod exec_log;
pub mod firmware_image;
pub mod instruction_mix;
pub mod thumb;
