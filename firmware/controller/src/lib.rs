//! The haptic controller, independent of any board: it converts encoder counts to metres, runs the
//! haptic cycle, and converts newtons to converter codes.
//!
//! ```text
//! link ─ inbox ─ HapticLoop::tick ─ Controller::tick ─ Cycle::tick (core) ─ port ─ outputs ─ Board
//!                                        device: counts to tip, force to codes
//! ```
//!
//! [`haptic_loop`] is one tick with deadline, read-back of the outputs and watchdog; [`serve`] runs
//! ticks for a host, timed or in lock-step. Both access the hardware through a [`board::Board`].
//! `firmware` adds boards, executors and the handling of crashes; the desktop runs this crate
//! unchanged.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod about;
pub mod aside;
pub mod board;
pub mod commission;
pub mod config;
pub mod controller;
pub mod crash;
pub mod device;
pub mod force_out;
pub mod haptic_loop;
pub mod kinematics;
pub mod link;
pub mod log;
pub mod patch;
pub mod port;
pub mod probe_in;
pub mod refusal;
pub mod resets;
pub mod script;
pub mod serve;
pub mod snapshot;
pub mod wire_limits;
pub mod words;
