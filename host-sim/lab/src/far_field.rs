//! Experiments on the far field: treatments of the edge of a patch, and a contact that slides.

pub mod rim_method;
pub mod sliding;
pub mod table;

pub use rim_method::{RimMethod, RimMethods};
