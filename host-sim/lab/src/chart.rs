//! `chart`: presses every method in the same way and plots the cost of a tick against the error.
//!
//! For each method, size and stiffness the chart measures the number of substeps that the method
//! needs to survive the deepest press (`survive`), the errors of its force and surface shape
//! against the converged reference (`accuracy`), and the cost of a tick on this machine (`timing`);
//! it estimates the cost on a Cortex-M4F (`cycles`). On request it also measures the force error
//! while the probe moves (`moving`).

mod accuracy;
mod cycles;
mod figures;
mod front;
mod moving;
pub mod peers;
mod reference;
mod report;
mod run;
mod scope;
mod survive;
mod timing;

pub use accuracy::{Accuracy, DEPTHS_M, SURFACE_DEPTHS_M, hold};
pub use cycles::{CYCLES_PER_FLOP, m4f_cycles};
pub use figures::figures;
pub use front::{front, front_of_three};
pub use moving::{Moving, SPEEDS_MM_PER_S};
pub use reference::Reference;
pub use report::{COSTS, ERRORS, FrontRow, MovingFrontRow, Quantity, fronts, moving_fronts, rows};
pub use run::{Measured, Run, measure};
pub use scope::{Scope, Task};
pub use survive::{CLEAR_M, Failure, MOST_SUBSTEPS, PressResult, Survival, least_substeps, try_press};
pub use timing::{TickTime, tick_time};
