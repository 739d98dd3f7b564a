//! Palpate live: press tissue with the mouse and see what a finger would feel, in a window or a
//! page.
//!
//! ```text
//! pointer, keys, panel ─ app ─ message ─ link ─ physics (the loop) ─ message ─ view, strips
//! ```
//!
//! The physics ([`physics`]) runs beside the drawing, in a thread on a desktop and in a worker in a
//! page ([`link`]); only [`message`]s pass between them. The loop itself, its traces and their
//! replay are in `palpate_loop::live`. Alternatively, [`follow`] shows what a board measured.

mod accepted;
pub mod app;
mod body;
mod camera;
mod controls;
mod cut;
mod drawn_body;
mod files;
#[cfg(not(target_family = "wasm"))]
pub mod follow;
mod keys;
pub mod link;
mod look;
pub mod message;
#[cfg(target_family = "wasm")]
mod page;
mod panel;
pub mod physics;
mod pointer;
mod shown;
mod strips;
mod touch;
mod view;
mod words;
