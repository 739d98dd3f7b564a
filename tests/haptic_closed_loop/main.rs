//! The loop closed over a device and a hand, armed and ramped in like a user's.

mod patch;
mod plant;
mod spring;
