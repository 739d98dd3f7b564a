//! The link to the host, a USART whose bytes a DMA moves: no tick of these boards has time for an
//! interrupt per byte, and none is lost while interrupts are off.

use core::sync::atomic::{AtomicU8, AtomicUsize, Ordering, fence};

use embassy_stm32::Peri;
use embassy_stm32::usart::{Instance, RxPin, TxPin, Uart};

use super::{Stm32Board, This, link_config};
use crate::board::queues;

#[cfg_attr(dma_streams, path = "dma_streams.rs")]
#[cfg_attr(not(dma_streams), path = "dma_channels.rs")]
mod dma;

/// Room for the bytes of 11 ms.
const RECEIVED_BYTES: usize = 1024;

/// A ring that the DMA fills.
static RECEIVED: [AtomicU8; RECEIVED_BYTES] = [const { AtomicU8::new(0) }; RECEIVED_BYTES];
/// Place in it of the oldest byte that has not been read.
static UNREAD: AtomicUsize = AtomicUsize::new(0);
/// Number of bytes of the queue that the DMA is sending.
static SENDING: AtomicUsize = AtomicUsize::new(0);

/// Claims the pins and starts to receive.
pub fn start<T: Instance>(usart: Peri<'static, T>, rx: Peri<'static, impl RxPin<T>>, tx: Peri<'static, impl TxPin<T>>) {
    let Ok(driver) = Uart::new_blocking(usart, rx, tx, link_config()) else { return };
    core::mem::forget(driver);
    dma::receive(&RECEIVED);
    This::LINK.cr3().modify(|w| {
        w.set_dmar(true);
        w.set_dmat(true);
    });
}

/// Reads the bytes received.
pub fn read(bytes: &mut [u8]) -> usize {
    send();
    dma::clear_errors();
    // nothing is left for an instant before the ring begins anew
    let end = RECEIVED_BYTES.saturating_sub(dma::left()) % RECEIVED_BYTES;
    fence(Ordering::Acquire); // the bytes are read after the DMA's count of them
    let (mut at, mut count) = (UNREAD.load(Ordering::Relaxed), 0);
    for place in bytes {
        let Some(byte) = RECEIVED.get(at).filter(|_| at != end) else { break };
        *place = byte.load(Ordering::Relaxed);
        at = if at + 1 < RECEIVED_BYTES { at + 1 } else { 0 };
        count += 1;
    }
    UNREAD.store(at, Ordering::Relaxed);
    count
}

/// Queues a frame, without blocking, or drops it if it does not fit as a whole.
pub fn write(frame: &[u8]) {
    queues::write(frame);
    send();
}

/// Lets the DMA send what waits, unless it is still sending.
fn send() {
    if dma::sends() {
        return;
    }
    queues::OUT.with(|queue| {
        queue.remove(SENDING.load(Ordering::Relaxed));
        let waiting = queue.first_piece(); // stays in the queue while it is sent
        SENDING.store(waiting.len(), Ordering::Relaxed);
        if !waiting.is_empty() {
            fence(Ordering::SeqCst); // the bytes are in memory before the DMA reads them
            dma::send(waiting);
        }
    });
}
