//! The loop closed over a device and a hand, armed and ramped in like a user's.

mod tissue;
mod wall;
