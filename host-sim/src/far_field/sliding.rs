//! Where the contact moves: a probe slides over the tissue, and the patch must answer everywhere on its way.

pub mod course;
pub mod run;

pub use course::{Course, Leg};
pub use run::{Awake, Figures, Slide, slide};
