//! The live loop is the loop of board and desktop, run one tick per call by the window or page that
//! draws it. It is recorded at the core's interface and repeated bit for bit.
//!
//! ```text
//! window, page (`host-sim/live`):
//! aim ─ hand and device ─ reading ─┬─ Cycle ─ force on the device
//!       (emulated, or the pointer) └─ trace: readings, requests, forces
//! `palpate live --replay`:
//! trace ─ Cycle ─ same bits?
//! ```
//!
//! It uses no clock, file or thread: the same code runs in a browser.

mod choice;
mod device;
mod exercise;
mod palpation;
pub mod replay;
mod tissue;
pub mod trace;

pub use choice::{Choice, Inside, Nodule, SIZES};
pub use device::{Holding, POINTER_FORCE_N};
pub use exercise::{Exercise, Found};
pub use palpation::{CLEAR_M, Live, Told};
pub use tissue::LiveTissue;
