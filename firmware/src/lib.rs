//! The hardware edges of the haptic controller, free of any board: what turns counts into metres and newtons into codes.
//! The binary beside this library adds the board, the two tasks and the reaction to faults.
#![no_std]
#![forbid(unsafe_code)]

pub mod deadline;
pub mod force_out;
pub mod patch;
pub mod placement;
pub mod probe_in;
