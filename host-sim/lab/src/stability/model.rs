//! The part of `stability` without a device in the loop: every method of the chart runs presses,
//! taps, jittered presses and releases at five stiffnesses.
//!
//! A [`LoadCase`] defines the motion of the tip and the tissue; a [`BuiltMethod`] is a method with
//! the substeps that it needs; [`press`] applies the case to the method and records a [`Trace`];
//! [`judge`] classifies the worst failure; [`margin`] finds the limit up to which the method still
//! passes; [`promises`] checks the promises of the product.
//!
//! Every method gets the substeps that it needs for the chart's press on the same tissue; the
//! product gets those that a session derives. The product runs with its guard: the depth limit, and
//! the sinking speed that its elements allow. The other methods have no depth limit; for all of
//! them except `implicit` and `compliance` the core limits the speed of the tip to 1 m/s.

mod built_method;
mod figures;
mod load_case;
mod margin;
mod matrix;
mod press;
mod promise;
mod report;
mod verdict;

pub use built_method::{Build, BuiltMethod, ROWS, Row};
pub use load_case::{CASES, CaseTissue, LoadCase, Promise, QUICK_CASES, Stimulus};
pub use margin::{Axis, Margin, largest, margin};
pub use matrix::{Cell, MarginCell, Matrix, Part, Scope, run};
pub use press::{Loading, Trace, press};
pub use promise::{LEAST_J, promises};
pub use report::report;
pub use verdict::{Figures, Verdict, judge};
