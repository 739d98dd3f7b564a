//! The link to the host, a USART with queues of its own: an interrupt above the haptic loop moves
//! bytes between them and two longer queues, so nothing is lost while a patch is opened. A DMA
//! would not see what the core's cache holds.

use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::usart::{Instance, RxPin, TxPin, Uart};
use embassy_stm32::{Peri, pac::usart::Usart};

use super::{Stm32Board, This, link_config};
use crate::board::{by_interrupt, queues};

/// Claims the pins and starts the interrupt.
pub fn start<T: Instance>(usart: Peri<'static, T>, rx: Peri<'static, impl RxPin<T>>, tx: Peri<'static, impl TxPin<T>>) {
    let Ok(driver) = Uart::new_blocking(usart, rx, tx, link_config()) else { return };
    core::mem::forget(driver);
    let registers = This::LINK;
    registers.cr1().modify(|w| w.set_ue(false));
    registers.cr1().modify(|w| w.set_fifoen(true));
    registers.cr1().modify(|w| w.set_ue(true));
    registers.cr1().modify(|w| w.set_rxneie(true));
    This::LINK_INTERRUPT.set_priority(Priority::P3);
    // SAFETY: its handler is `on_interrupt`, which touches nothing but this file's queues.
    unsafe { This::LINK_INTERRUPT.enable() };
}

/// Reads the bytes received. The interrupt is pended as well, so that transfers resume in the next
/// tick if an error flag has masked its source.
pub fn read(bytes: &mut [u8]) -> usize {
    This::LINK_INTERRUPT.pend();
    by_interrupt::read(bytes)
}

/// Queues a frame, without blocking, or drops it if it does not fit as a whole.
pub fn write(frame: &[u8]) {
    queues::write(frame);
    This::LINK_INTERRUPT.pend();
}

/// Moves all received bytes to their queue, and queued bytes to the USART while it accepts them.
pub fn on_interrupt() {
    let registers = This::LINK;
    by_interrupt::keep(|| received(registers));
    let waits = by_interrupt::send(|| registers.isr().read().txe(), |byte| registers.tdr().write(|w| w.set_dr(byte.into())));
    // once the queue is empty, not for every byte that leaves it
    registers.cr1().modify(|w| w.set_txfeie(waits));
}

fn received(usart: Usart) -> Option<u8> {
    let status = usart.isr().read();
    if status.ore() {
        usart.icr().write(|w| w.set_ore(true));
    }
    status.rxne().then(|| usart.rdr().read().dr() as u8)
}
