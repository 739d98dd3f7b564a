//! The haptic loop where it must not fail: under every fault, on random paths, in yielding hands,
//! and in hours of normal use.
//!
//! [`campaign`] injects the faults of [`faulty`]; [`paths`] leads a position-controlled tip through
//! and around every shipped patch; [`yielding`] lets a hand with mass hold devices of any count,
//! delay and lag; [`soak`] never restarts the loop. Every tick is watched against the invariants of
//! `palpate_loop::closed_loop::watch`.

pub mod campaign;
pub mod faulty;
pub mod paths;
pub mod soak;
pub mod yielding;
