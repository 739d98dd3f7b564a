//! Palpate on the desktop.
pub mod mesh;
pub mod patch;
