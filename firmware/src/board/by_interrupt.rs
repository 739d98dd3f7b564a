//! The link of a board whose UART has an interrupt move the bytes.

use palpate_controller::link::ByteQueue;

use super::queues::{OUT, Shared};

/// Bytes from the host.
static IN: Shared<ByteQueue> = Shared::new(ByteQueue::EMPTY);

/// Reads the bytes received so far, without blocking.
pub fn read(bytes: &mut [u8]) -> usize {
    IN.with(|queue| queue.read(bytes))
}

/// Queues received bytes until `next` returns `None`. Interrupts are off meanwhile, for as many
/// bytes as the UART's own queue holds.
pub fn keep(mut next: impl FnMut() -> Option<u8>) {
    IN.with(|queue| {
        while let Some(byte) = next() {
            queue.push(byte);
        }
    });
}

/// Moves bytes for the host to the UART, as long as it accepts them, and returns whether some may
/// still wait. Interrupts are off meanwhile, for as many bytes as the UART's own queue holds.
pub fn send(accepts: impl Fn() -> bool, send: impl Fn(u8)) -> bool {
    OUT.with(|queue| {
        let mut count = 0;
        for byte in queue.first_piece().iter().take_while(|_| accepts()) {
            send(*byte);
            count += 1;
        }
        queue.remove(count);
        !queue.first_piece().is_empty()
    })
}
