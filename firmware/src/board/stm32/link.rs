//! The link to the host, a USART at 115 200 baud: an interrupt above the haptic loop moves bytes
//! between its registers and two queues, so nothing is lost while a patch is opened.

use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::usart::{Config, Instance, RxPin, TxPin, Uart};
use embassy_stm32::{Peri, pac::usart::Usart};

use super::{Stm32Board, This};
use crate::board::queues;

/// Claims the pins and starts the interrupt.
pub fn start<T: Instance>(usart: Peri<'static, T>, rx: Peri<'static, impl RxPin<T>>, tx: Peri<'static, impl TxPin<T>>) {
    let Ok(driver) = Uart::new_blocking(usart, rx, tx, Config::default()) else { return };
    core::mem::forget(driver);
    let registers = This::LINK;
    #[cfg(usart_fifo)]
    {
        registers.cr1().modify(|w| w.set_ue(false));
        registers.cr1().modify(|w| w.set_fifoen(true));
        registers.cr1().modify(|w| w.set_ue(true));
    }
    registers.cr1().modify(|w| w.set_rxneie(true));
    This::LINK_INTERRUPT.set_priority(Priority::P3);
    // SAFETY: its handler is `on_interrupt`, which touches nothing but this file's queues.
    unsafe { This::LINK_INTERRUPT.enable() };
}

/// Reads the bytes received. The interrupt is pended as well, so that transfers resume in the next
/// tick if an error flag has masked its source.
pub fn read(bytes: &mut [u8]) -> usize {
    This::LINK_INTERRUPT.pend();
    queues::read(bytes)
}

/// Queues a frame, without blocking, or drops it if it does not fit as a whole.
pub fn write(frame: &[u8]) {
    queues::write(frame);
    This::LINK_INTERRUPT.pend();
}

/// Moves all received bytes to their queue, and queued bytes to the USART while it accepts them.
pub fn on_interrupt() {
    let registers = This::LINK;
    while let Some(byte) = received(registers) {
        queues::keep(byte);
    }
    let waits = queues::send(|| can_send(registers), |byte| send(registers, byte));
    registers.cr1().modify(|w| w.set_txeie(waits));
}

#[cfg(not(usart_v2))]
fn received(usart: Usart) -> Option<u8> {
    let status = usart.isr().read();
    if status.ore() {
        usart.icr().write(|w| w.set_ore(true));
    }
    status.rxne().then(|| usart.rdr().read().dr() as u8)
}

#[cfg(not(usart_v2))]
fn can_send(usart: Usart) -> bool {
    usart.isr().read().txe()
}

#[cfg(not(usart_v2))]
fn send(usart: Usart, byte: u8) {
    usart.tdr().write(|w| w.set_dr(byte.into()));
}

/// Reading the data register also clears an overrun.
#[cfg(usart_v2)]
fn received(usart: Usart) -> Option<u8> {
    let status = usart.sr().read();
    (status.rxne() || status.ore()).then(|| usart.dr().read().dr() as u8)
}

#[cfg(usart_v2)]
fn can_send(usart: Usart) -> bool {
    usart.sr().read().txe()
}

#[cfg(usart_v2)]
fn send(usart: Usart, byte: u8) {
    usart.dr().write(|w| w.set_dr(byte.into()));
}
