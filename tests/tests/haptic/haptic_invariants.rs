//! Invariants hold in every tick of the haptic loop, whatever the device, the hand and the host do;
//! breaking one is noticed.

mod defects;
mod random;
mod rig;
mod scenes;
