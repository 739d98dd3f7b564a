//! The queue of the bytes for the host. Interrupts are off while a frame is copied, not once for
//! each byte.

use core::cell::RefCell;

use embassy_sync::blocking_mutex::{Mutex, raw::CriticalSectionRawMutex};
use palpate_controller::link::ByteQueue;

/// A value that interrupts share.
pub struct Shared<T>(Mutex<CriticalSectionRawMutex, RefCell<T>>);

impl<T> Shared<T> {
    pub const fn new(value: T) -> Self {
        Self(Mutex::new(RefCell::new(value)))
    }

    /// Calls `of` with interrupts off, so that nobody else has the value; if somebody had, nothing
    /// would happen. A panic in its place would take 2 KB of flash.
    pub fn with<R: Default>(&self, of: impl FnOnce(&mut T) -> R) -> R {
        self.0.lock(|value| value.try_borrow_mut().map(|mut value| of(&mut value)).unwrap_or_default())
    }
}

/// Bytes for the host.
pub static OUT: Shared<ByteQueue> = Shared::new(ByteQueue::EMPTY);

/// Number of bytes for the host that there is room for.
pub fn room() -> usize {
    OUT.with(|queue| queue.room())
}

/// Queues a frame for the host, or drops it if it does not fit as a whole.
pub fn write(frame: &[u8]) {
    OUT.with(|queue| queue.write(frame));
}
