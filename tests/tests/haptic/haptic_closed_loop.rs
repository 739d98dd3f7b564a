//! The closed loop of device and hand, armed and ramped in as a user would do it.

mod tissue;
mod wall;
