//! Palpate from C and C++: a haptic session behind a handle.
//!
//! ```text
//! C: palpate_tick ─ ffi ─ sessions ─ palpate_loop::haptic_session ─ force
//!                   pointers  handles    gate, patch, limits
//! ```
//!
//! [`ffi`] is the boundary: it converts pointers to values and back, catches panics, and returns
//! codes. It and `pointers` alone have `unsafe`. The header `include/palpate.h` is generated from
//! [`ffi`], [`code`] and [`records`]; `README.md` shows how to build, link and run.

pub mod code;
pub mod ffi;
mod message;
mod pointers;
pub mod records;
mod sessions;
