//! The haptic controller, free of any board: counts become metres, the haptic cycle runs, newtons become converter codes.
//! The binary beside this library adds the board, the tasks and the reaction to crashes; the desktop runs the library as it is.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod config;
pub mod controller;
pub mod edge;
pub mod force_out;
pub mod kinematics;
pub mod link;
pub mod patch;
pub mod placement;
pub mod probe_in;
pub mod resets;
pub mod script;
pub mod words;
