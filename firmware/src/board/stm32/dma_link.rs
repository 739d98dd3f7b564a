//! The link to the host, a USART whose registers hold one byte, for 11 us: two DMA streams move the
//! bytes, so nothing is lost while interrupts are off, and no tick is interrupted for a byte.

use core::sync::atomic::{AtomicU8, AtomicUsize, Ordering, fence};

use embassy_stm32::Peri;
use embassy_stm32::pac::DMA1;
use embassy_stm32::pac::dma::vals::Dir;
use embassy_stm32::usart::{Instance, RxPin, TxPin, Uart};

use super::{Stm32Board, This, link_config};
use crate::board::queues;

/// Streams of DMA1 that serve USART2, and their channel (RM0390, table 28).
const RECEIVES: usize = 5;
const SENDS: usize = 6;
const CHANNEL: u8 = 4;
/// Place of both streams' flags: the second register, streams 5 and 6 of 4 to 7.
const FLAGS: usize = SENDS / 4;

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
    let data = This::LINK.dr().as_ptr() as u32;
    let [receives, sends] = [RECEIVES, SENDS].map(|stream| DMA1.st(stream));
    for stream in [receives, sends] {
        stream.par().write_value(data);
    }
    receives.m0ar().write_value(RECEIVED.as_ptr() as u32);
    receives.ndtr().write(|w| w.set_ndt(RECEIVED_BYTES as u16));
    receives.cr().write(|w| {
        w.set_chsel(CHANNEL);
        w.set_minc(true);
        w.set_circ(true);
        w.set_en(true);
    });
    This::LINK.cr3().modify(|w| {
        w.set_dmar(true);
        w.set_dmat(true);
    });
}

/// Reads the bytes received.
pub fn read(bytes: &mut [u8]) -> usize {
    send();
    let left = usize::from(DMA1.st(RECEIVES).ndtr().read().ndt());
    let end = RECEIVED_BYTES.saturating_sub(left);
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
    let stream = DMA1.st(SENDS);
    if stream.cr().read().en() {
        return;
    }
    queues::OUT.with(|queue| {
        queue.remove(SENDING.load(Ordering::Relaxed));
        let waiting = queue.first_piece(); // stays in the queue while it is sent
        SENDING.store(waiting.len(), Ordering::Relaxed);
        if waiting.is_empty() {
            return;
        }
        // a stream with a flag set does not start
        DMA1.ifcr(FLAGS).write(|w| {
            let of = SENDS % 4;
            w.set_feif(of, true);
            w.set_dmeif(of, true);
            w.set_teif(of, true);
            w.set_htif(of, true);
            w.set_tcif(of, true);
        });
        stream.m0ar().write_value(waiting.as_ptr() as u32);
        stream.ndtr().write(|w| w.set_ndt(waiting.len() as u16));
        fence(Ordering::SeqCst); // the bytes are in memory before the DMA reads them
        stream.cr().write(|w| {
            w.set_chsel(CHANNEL);
            w.set_dir(Dir::MEMORY_TO_PERIPHERAL);
            w.set_minc(true);
            w.set_en(true);
        });
    });
}
