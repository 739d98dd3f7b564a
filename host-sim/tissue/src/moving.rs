//! How right the force on a moving probe is.
//!
//! A press that is held tells nothing about it: floored masses push against a probe that moves, and
//! let go of one that rests. Where a dynamic truth is stored ([`truth`], [`table`]) a ramp is
//! judged against it ([`ramp`]), and so is any other motion ([`trajectory`]); elsewhere against the
//! same patch with much shorter substeps ([`self_check`]), which carry almost the true masses.

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
