//! Yielding hands on patches: a hand with mass, stiffness and damping holds a device of any count,
//! delay and lag, and does what people do. A run is a list of numbers between 0 and 1, so that the
//! same code draws a run at random and lets an adversary search for the worst one.
//!
//! Energy, contact and vibration are judged from the true position of the tip and the force that
//! acts, never from what the loop reports.

mod case;
mod motion;
mod run;

pub use case::{GENES, YieldingCase};
pub use motion::{Motion, MotionKind};
pub use run::{Outcome, Seen};
