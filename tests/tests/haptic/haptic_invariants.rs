//! Invariants hold in every tick of the haptic loop, whatever device, hand and host do, and the
//! checks detect a broken one.

mod bound;
mod defects;
mod random;
mod rig;
mod scenes;
