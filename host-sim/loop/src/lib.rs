//! The haptic loop on the desktop: the core's controller, closed over an emulated hand and device,
//! or over the pointer.
//!
//! ```text
//! hand ─ device ─ reading ─ core::haptic::Cycle ─ force ─ device     watched from outside
//! ```
//!
//! [`closed_loop`] closes it over emulated hands and devices; [`live`] is the same loop,
//! driven by a window or a page; [`haptic_session`] leaves the device to its caller, in any
//! language. [`board_trace`] is the table in which a board's records are stored.

pub mod board_trace;
pub mod closed_loop;
pub mod commissioning;
pub mod day;
pub mod haptic_session;
#[cfg(test)]
mod jump_tests;
pub mod live;
