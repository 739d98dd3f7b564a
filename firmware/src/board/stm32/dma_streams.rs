//! Streams 5 and 6 of DMA1, which serve USART2 of an STM32F446 on their channel 4 (RM0390, table
//! 28).

use core::sync::atomic::AtomicU8;

use embassy_stm32::pac::{DMA1, USART2, dma::vals::Dir};

const RECEIVES: usize = 5;
const SENDS: usize = 6;
const CHANNEL: u8 = 4;

/// Begins to write the bytes received to a ring, without an end.
pub fn receive(ring: &'static [AtomicU8]) {
    let stream = DMA1.st(RECEIVES);
    stream.par().write_value(USART2.dr().as_ptr() as u32);
    stream.m0ar().write_value(ring.as_ptr() as u32);
    stream.ndtr().write(|w| w.set_ndt(ring.len() as u16));
    stream.cr().write(|w| {
        w.set_chsel(CHANNEL);
        w.set_minc(true);
        w.set_circ(true);
        w.set_en(true);
    });
}

/// Clears the flag of a byte that was lost, with which nothing is received; its frame fails its
/// checksum. The other errors stop no DMA.
pub fn clear_errors() {
    if USART2.sr().read().ore() {
        USART2.dr().read();
    }
}

/// Number of bytes until the end of the ring.
pub fn left() -> usize {
    DMA1.st(RECEIVES).ndtr().read().ndt().into()
}

/// Whether bytes are being sent.
pub fn sends() -> bool {
    DMA1.st(SENDS).cr().read().en()
}

/// Sends bytes, which must stay where they are meanwhile.
pub fn send(bytes: &[u8]) {
    // a stream with a flag set does not start
    DMA1.ifcr(SENDS / 4).write(|w| {
        let of = SENDS % 4;
        w.set_feif(of, true);
        w.set_dmeif(of, true);
        w.set_teif(of, true);
        w.set_htif(of, true);
        w.set_tcif(of, true);
    });
    let stream = DMA1.st(SENDS);
    stream.par().write_value(USART2.dr().as_ptr() as u32);
    stream.m0ar().write_value(bytes.as_ptr() as u32);
    stream.ndtr().write(|w| w.set_ndt(bytes.len() as u16));
    stream.cr().write(|w| {
        w.set_chsel(CHANNEL);
        w.set_dir(Dir::MEMORY_TO_PERIPHERAL);
        w.set_minc(true);
        w.set_en(true);
    });
}
