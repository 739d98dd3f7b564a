//! What holds in every tick of the haptic loop, whatever the device, the hand and the host do; and
//! that breaking it is noticed.

mod defects;
mod random;
mod rig;
mod scenes;
