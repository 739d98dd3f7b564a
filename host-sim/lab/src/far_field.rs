//! Experiments on the far field: what can stand at the edge of a patch, and a contact that slides.

pub mod edges;
pub mod sliding;
pub mod table;

pub use edges::{Edge, Edges};
