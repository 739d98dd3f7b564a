//! Honest motions over the shipped patches, with overflow checks and debug assertions: none may end
//! in a fault, and the same motions with a wrong sign must still be stopped.

mod readings;
mod rig;
mod slides;
