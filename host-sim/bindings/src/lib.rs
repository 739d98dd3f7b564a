//! Palpate from C and C++: a haptic session behind a handle.
//!
//! ```text
//! C: palpate_tick ─ ffi ─ sessions ─ palpate_loop::haptic_session ─ force
//!                   pointers  handles    gate, patch, limits
//! ```
//!
//! [`ffi`] is the boundary and the one file with `unsafe`: it turns pointers into values and back,
//! catches panics, and gives codes. The header `include/palpate.h` is made from it, [`code`] and
//! [`records`]; `README.md` shows how to build, link and run.

pub mod code;
pub mod ffi;
mod message;
pub mod records;
mod sessions;
