//! Accuracy of the force on a moving probe.
//!
//! A held press does not show the error of floored masses: they resist a moving probe, but not one
//! at rest. If a dynamic reference is stored ([`truth`], [`table`]), ramps ([`ramp`]) and other
//! motions ([`trajectory`]) are compared with it. In any case the patch is compared with itself at
//! much shorter substeps, which need almost no added mass, in the motions of a hand
//! ([`self_check`]).

pub mod ramp;
pub mod self_check;
pub mod table;
pub mod trajectory;
pub mod truth;

pub use crate::truth_error::TruthError;
pub use ramp::{Ramp, RampError};
pub use self_check::{Approach, SelfCheck, Worst, with_substeps};
pub use table::Table;
pub use trajectory::CourseError;
pub use truth::{Site, TRUTHS, Trajectory, Truth};
