//! Identifies modulus, stiffening, relaxation and friction of a tissue from indentations of it.
//!
//! ```text
//! record (columns, contact, segments) ─ elastic (axial: finite elements) ─ model ─ fit ─ study
//! ```

pub mod axial;
pub mod elastic;
pub mod estimate;
pub mod fit;
pub mod model;
pub mod record;
pub mod slide;
pub mod study;
mod unsaid;
