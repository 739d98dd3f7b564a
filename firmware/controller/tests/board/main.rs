//! The tick of a board and the service of its host, on a mock board: deadline, read-back of the
//! outputs, watchdog, link. Takes milliseconds, without an emulator.

mod logged;
mod mock;
mod served;
mod ticks;
