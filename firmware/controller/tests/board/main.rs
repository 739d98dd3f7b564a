//! The tick of a board and its host's service, on a board of the test: deadline, read-back of the
//! outputs, watchdog, link. Milliseconds, no emulator.

mod mock;
mod served;
mod ticks;
