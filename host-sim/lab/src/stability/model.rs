//! The part of `stability` without a device in the loop: every method of the chart is pressed,
//! tapped, jittered and released at five stiffnesses.
//!
//! A [`LoadCase`] says how the tip moves; a [`BuiltMethod`] is a method with the substeps that it
//! needs; [`press`] applies the case to the method and records a [`Trace`]; [`judge`] classifies
//! the first failure; [`margin`] finds how much more it withstands; [`promises`] checks the
//! product's promises.
//!
//! Every method gets the substeps that it needs for the chart's press on the same tissue; the
//! product those that a session derives. The product runs with its guard: the depth limit, and the
//! sinking speed that its elements allow. The other methods have no depth limit; all of them except
//! the implicit ones and `compliance` are given a tip that moves at 1 m/s at most.

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
pub use figures::draw;
pub use load_case::{CASES, CaseTissue, LoadCase, Promise, QUICK_CASES, Stimulus};
pub use margin::{Axis, Margin, largest, margin};
pub use matrix::{Cell, MarginCell, Matrix, Part, Scope, run};
pub use press::{Loading, Trace, press};
pub use promise::{LEAST_J, promises};
pub use report::{Summary, write};
pub use verdict::{Figures, Verdict, judge};
