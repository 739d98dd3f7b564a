//! Experiments on the far field: what can stand at the edge of a patch, and a contact that slides.

pub mod rim_treatment;
pub mod sliding;
pub mod table;

pub use rim_treatment::{RimTreatment, RimTreatments};
