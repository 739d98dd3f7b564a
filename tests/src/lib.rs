//! What the tests share: the firmware in the emulator, its image and what it executed; the built command and what it wrote.
#![forbid(unsafe_code)]

pub mod cube_mesh;
pub mod emulator;
pub mod exec_log;
pub mod firmware_image;
pub mod instruction_mix;
pub mod palpate_command;
pub mod press_run;
pub mod thumb;
