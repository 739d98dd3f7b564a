//! Pins by port and number, without driver or lock, for code that also runs in fault handlers.

use embassy_stm32::pac::gpio::{
    Gpio,
    vals::{Idr, Odr},
};
use palpate_controller::force_out::bridge::Line;

/// A pin of the chip.
#[derive(Clone, Copy)]
pub struct Pin {
    /// Port of the pin.
    pub port: Gpio,
    /// Number of the pin in the port, 0 to 15.
    pub number: usize,
}

impl Pin {
    /// Whether the pin's level is high now.
    pub fn is_high(self) -> bool {
        self.port.idr().read().idr(self.number) == Idr::HIGH
    }

    /// Register and level of an output.
    pub fn line(self) -> Line {
        Line { register: self.port.odr().read().odr(self.number) == Odr::HIGH, level: self.is_high() }
    }

    /// Drives an output.
    pub fn set(self, high: bool) {
        self.port.bsrr().write(|w| if high { w.set_bs(self.number, true) } else { w.set_br(self.number, true) });
    }
}
