//! CMSDK UART 0 as the link: interrupts move bytes between its one-byte registers and two queues.

use cortex_m::peripheral::NVIC;
use palpate_controller::link::BAUD;

use super::{CLOCK_HZ, Interrupt, set_priority};
use crate::board::{by_interrupt, queues};

const DATA: *mut u32 = 0x4000_4000 as *mut u32;
const STATE: *mut u32 = 0x4000_4004 as *mut u32;
const CTRL: *mut u32 = 0x4000_4008 as *mut u32;
const INTCLEAR: *mut u32 = 0x4000_400C as *mut u32;
const BAUDDIV: *mut u32 = 0x4000_4010 as *mut u32;
const SEND_FULL: u32 = 1;
const RECEIVE_FULL: u32 = 2;
const SENT: u32 = 1;
const RECEIVED: u32 = 2;
/// Control bits of sender and receiver and of their interrupts.
const ENABLE: u32 = 0b1111;

pub fn start() {
    for interrupt in [Interrupt::UartReceived, Interrupt::UartSent] {
        set_priority(interrupt);
    }
    // SAFETY: the UART belongs to this file; its handlers are in the table.
    unsafe {
        BAUDDIV.write_volatile(CLOCK_HZ / BAUD);
        CTRL.write_volatile(ENABLE);
        NVIC::unmask(Interrupt::UartReceived);
        NVIC::unmask(Interrupt::UartSent);
    }
}

/// Queues a frame, without blocking, or drops it if it does not fit as a whole.
pub fn write(frame: &[u8]) {
    queues::write(frame);
    NVIC::pend(Interrupt::UartSent); // starts sending, if the UART is idle
}

pub extern "C" fn on_received() {
    // SAFETY: registers of a UART that nothing but this file touches; reading the data removes it.
    unsafe {
        INTCLEAR.write_volatile(RECEIVED);
        by_interrupt::keep(|| (STATE.read_volatile() & RECEIVE_FULL != 0).then(|| DATA.read_volatile() as u8));
    }
}

pub extern "C" fn on_sent() {
    // SAFETY: as above.
    unsafe {
        INTCLEAR.write_volatile(SENT);
        by_interrupt::send(|| STATE.read_volatile() & SEND_FULL == 0, |byte| DATA.write_volatile(byte.into()));
    }
}
