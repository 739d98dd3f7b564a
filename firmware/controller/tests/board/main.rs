//! The tick of a board and the service of its host, on a mock board: deadline, read-back of the
//! outputs, watchdog, link, and the mechanisms of its devices. The tests need no emulator and run
//! in milliseconds.

mod commissioning;
mod devices;
mod hosts;
mod kinematics_keep_power;
mod logged;
mod mechanisms;
mod mock;
mod served;
mod ticks;
