//! Channels 1 and 2 of DMA1, to which the multiplexer of an STM32G474 gives the requests of USART2
//! (RM0440, table 91).

use core::sync::atomic::AtomicU8;

use embassy_stm32::pac::{DMA1, DMAMUX1, USART2, bdma::vals::Dir};

// counted from zero
const RECEIVES: usize = 0;
const SENDS: usize = 1;
const REQUESTS: [u8; 2] = [26, 27];

/// Begins to write the bytes received to a ring, without an end.
pub fn receive(ring: &'static [AtomicU8]) {
    for (channel, request) in REQUESTS.into_iter().enumerate() {
        DMAMUX1.ccr(channel).write(|w| w.set_dmareq_id(request));
    }
    let channel = DMA1.ch(RECEIVES);
    channel.par().write_value(USART2.rdr().as_ptr() as u32);
    channel.mar().write_value(ring.as_ptr() as u32);
    channel.ndtr().write(|w| w.set_ndt(ring.len() as u16));
    channel.cr().write(|w| {
        w.set_minc(true);
        w.set_circ(true);
        w.set_en(true);
    });
}

/// Clears the flags of a byte that was lost or disturbed, which may block reception; its frame
/// fails its checksum.
pub fn clear_errors() {
    USART2.icr().write(|w| {
        w.set_ore(true);
        w.set_fe(true);
        w.set_ne(true);
        w.set_pe(true);
    });
}

/// Number of bytes until the end of the ring.
pub fn left() -> usize {
    DMA1.ch(RECEIVES).ndtr().read().ndt().into()
}

/// Whether bytes are being sent.
pub fn sends() -> bool {
    let channel = DMA1.ch(SENDS);
    channel.cr().read().en() && channel.ndtr().read().ndt() > 0
}

/// Sends bytes, which must stay where they are meanwhile.
pub fn send(bytes: &[u8]) {
    let channel = DMA1.ch(SENDS);
    channel.cr().write(|w| w.set_en(false)); // a channel that runs takes no settings
    DMA1.ifcr().write(|w| w.set_teif(SENDS, true)); // while it is set, the channel does not start
    channel.par().write_value(USART2.tdr().as_ptr() as u32);
    channel.mar().write_value(bytes.as_ptr() as u32);
    channel.ndtr().write(|w| w.set_ndt(bytes.len() as u16));
    channel.cr().write(|w| {
        w.set_dir(Dir::FROM_MEMORY);
        w.set_minc(true);
        w.set_en(true);
    });
}
