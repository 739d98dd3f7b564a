//! The queues between the haptic loop and a board's UART, whose interrupt moves their bytes.
//! Interrupts are off while a frame is copied, not once for each byte.

use core::cell::RefCell;

use embassy_sync::blocking_mutex::{Mutex, raw::CriticalSectionRawMutex};
use palpate_controller::link::ByteQueue;

type Queue = Mutex<CriticalSectionRawMutex, RefCell<ByteQueue>>;

static IN: Queue = Mutex::new(RefCell::new(ByteQueue::EMPTY));
static OUT: Queue = Mutex::new(RefCell::new(ByteQueue::EMPTY));

/// Reads the bytes received so far, without blocking.
pub fn read(bytes: &mut [u8]) -> usize {
    IN.lock(|queue| queue.borrow_mut().read(bytes))
}

/// Number of bytes for the host that there is room for.
pub fn room() -> usize {
    OUT.lock(|queue| queue.borrow().room())
}

/// Queues a frame for the host, or drops it if it does not fit as a whole.
pub fn write(frame: &[u8]) {
    OUT.lock(|queue| queue.borrow_mut().write(frame));
}

/// Keeps a byte that was received.
pub fn keep(byte: u8) {
    IN.lock(|queue| queue.borrow_mut().push(byte));
}

/// Moves bytes for the host to the UART, as long as it accepts them, and returns whether some may
/// still wait. Interrupts are off meanwhile, for as many bytes as the UART's own queue holds.
pub fn send(accepts: impl Fn() -> bool, send: impl Fn(u8)) -> bool {
    OUT.lock(|queue| {
        let mut queue = queue.borrow_mut();
        loop {
            if !accepts() {
                return true;
            }
            let Some(byte) = queue.pop() else { return false };
            send(byte);
        }
    })
}
