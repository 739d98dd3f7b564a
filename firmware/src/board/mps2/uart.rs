//! CMSDK UART 0 as the link: interrupts move bytes between its one-byte registers and two queues.

use cortex_m::peripheral::NVIC;
use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, channel::Channel};

use super::{CLOCK_HZ, Interrupt, set_priority};

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
const BAUD: u32 = 115_200;

/// Queues with room for four of the longest frames each. Received bytes that do not fit are lost,
/// and their frame is dropped for its checksum.
static IN: Channel<CriticalSectionRawMutex, u8, 1024> = Channel::new();
static OUT: Channel<CriticalSectionRawMutex, u8, 1024> = Channel::new();

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

/// Reads the bytes received so far, without blocking.
pub fn read(bytes: &mut [u8]) -> usize {
    bytes.iter_mut().map_while(|byte| IN.try_receive().ok().map(|came| *byte = came)).count()
}

/// Number of bytes that the queue has room for.
pub fn room() -> usize {
    OUT.free_capacity()
}

/// Puts a frame in the queue, without blocking, or drops it if it does not fit as a whole.
pub fn write(bytes: &[u8]) {
    if OUT.free_capacity() < bytes.len() {
        return;
    }
    for byte in bytes {
        let _ = OUT.try_send(*byte); // there is room
    }
    NVIC::pend(Interrupt::UartSent); // starts sending, if the UART is idle
}

pub extern "C" fn on_received() {
    // SAFETY: registers of a UART that nothing but this file touches; reading the data removes it.
    unsafe {
        INTCLEAR.write_volatile(RECEIVED);
        while STATE.read_volatile() & RECEIVE_FULL != 0 {
            let _ = IN.try_send(DATA.read_volatile() as u8); // no room: lost, see above
        }
    }
}

pub extern "C" fn on_sent() {
    // SAFETY: as above.
    unsafe {
        INTCLEAR.write_volatile(SENT);
        while STATE.read_volatile() & SEND_FULL == 0 {
            let Ok(byte) = OUT.try_receive() else { return };
            DATA.write_volatile(byte.into());
        }
    }
}
