//! Closes the loop over an emulated hand and device, to show what a person would feel.
//!
//! ```text
//! stimulus ─ hand ─ plant ─ sense ─ core::haptic::cycle ─ actuate ─ plant
//!                             every tick is watched against the invariants
//! ```
//!
//! A [`rig`] drives and checks every emulated loop; [`run::run`] runs one with a hand. A [`device`]
//! profile and a [`hand`] are data; the [`surface`] is a wall or the product's patch. Campaigns of
//! faults, paths and yielding hands, and rival controllers, are part of the evidence.

pub mod butterworth;
pub mod device;
pub mod drive;
pub mod fidelity;
pub mod hand;
pub mod plant;
pub mod prepared;
pub mod report;
pub mod rig;
pub mod run;
pub mod spectrum;
pub mod stimulus;
pub mod surface;
pub mod trace;
pub mod verdict;
pub mod watch;
pub mod wiring;
