//! Accuracy of the force on a moving probe.
//!
//! A held press does not show it: floored masses push against a moving probe and not against one at
//! rest. If a dynamic reference is stored ([`truth`], [`table`]), a ramp is compared with it
//! ([`ramp`]), and so is any other motion ([`trajectory`]); otherwise it is compared with the same
//! patch with much shorter substeps ([`self_check`]), which carry almost the true masses.

pub mod error;
pub mod ramp;
pub mod self_check;
pub mod table;
pub mod trajectory;
pub mod truth;

pub use error::TruthError;
pub use ramp::{Ramp, RampError};
pub use self_check::{Approach, SelfCheck, with_substeps};
pub use table::Table;
pub use trajectory::CourseError;
pub use truth::{Site, TRUTHS, Trajectory, Truth};
