//! The loop closed over an emulated hand and device: what a person would feel.
//!
//! ```text
//! stimulus ─ hand ─ plant ─ sense ─ core::haptic::cycle ─ actuate ─ plant
//!                             every tick is watched against the invariants
//! ```
//!
//! [`run::run`] runs it; [`campaign`] runs it with the faults of [`faulty`]. A [`device`] profile
//! and a [`hand`] are data; a [`controller`] is the product's or another; a [`surface`] is a wall
//! or the product's patch; the criteria of a [`verdict`] do not change.

pub mod campaign;
pub mod controller;
pub mod device;
pub mod faulty;
pub mod fidelity;
pub mod hand;
pub mod mistakes;
pub mod paths;
pub mod plant;
pub mod prepared;
pub mod report;
pub mod run;
pub mod soak;
pub mod spectrum;
pub mod stimulus;
pub mod surface;
pub mod trace;
pub mod verdict;
pub mod watch;
