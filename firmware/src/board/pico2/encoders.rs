//! Three encoders, each counted by a state machine of `PIO0`.
//!
//! The program keeps its count in Y and publishes it after every sample. A sample and the previous
//! one form a number of four bits; the program jumps to that address, where a table of sixteen
//! jumps increases, decreases or keeps the count (also if both lines changed because an edge was
//! missed).

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_rp::Peri;
use embassy_rp::gpio::{AnyPin, Input, Pull};
use embassy_rp::pac::PIO0;
use embassy_rp::pio::program::pio_asm;
use palpate::haptic::device::SensorStatus;
use palpate_controller::probe_in::{EncoderCounts, JointReading, Reading};

/// First pin of each encoder; its other line is on the next pin.
const FIRST_PINS: [u8; 3] = [2, 4, 6];
/// Largest number of values in a queue; the last one is the newest.
const QUEUE: usize = 8;

/// Counts at the last edge of the tick timer.
static LATCHED: [AtomicU32; 3] = [const { AtomicU32::new(0) }; 3];
static READINGS: AtomicU32 = AtomicU32::new(0);

/// Claims the pins and starts the state machines. The pull-ups keep open-collector outputs and
/// unplugged inputs from floating.
pub fn start(pins: [Peri<'static, AnyPin>; 6]) {
    for pin in pins {
        core::mem::forget(Input::new(pin, Pull::Up));
    }
    let program = pio_asm!(
        ".origin 0",
        "jmp stay", // 00 to 00; the lower bit is the first pin
        "jmp rise", // 00 to 01
        "jmp fall", // 00 to 10
        "jmp stay",
        "jmp fall", // 01 to 00
        "jmp stay",
        "jmp stay",
        "jmp rise", // 01 to 11
        "jmp rise", // 10 to 00
        "jmp stay",
        "jmp stay",
        "jmp fall", // 10 to 11
        "jmp stay",
        "jmp fall", // 11 to 01
        "jmp rise", // 11 to 10
        "jmp stay",
        "fall:",
        "jmp y--, stay", // continues with the next line in both cases
        "stay:",
        "mov isr, y",
        "push noblock",
        "mov isr, null",
        "out isr, 2", // the previous sample
        "in pins, 2",
        "mov osr, isr",
        "mov pc, isr",
        "rise:",
        "mov y, ~y", // minus one is the complement of plus one
        "jmp y--, back",
        "back:",
        "mov y, ~y",
        "jmp stay",
    );
    for (place, code) in program.program.code.iter().enumerate() {
        PIO0.instr_mem(place).write(|w| w.set_instr_mem(*code));
    }
    // `set y, 0`, `mov osr, null` and `jmp stay`, as the manual encodes them
    let begin = [0xE040, 0xA0E3, 17];
    for (number, pin) in FIRST_PINS.into_iter().enumerate() {
        let machine = PIO0.sm(number);
        machine.clkdiv().write(|w| w.set_int(1));
        machine.shiftctrl().write(|w| w.set_out_shiftdir(true)); // shifts in to the left, out from the right
        machine.pinctrl().write(|w| w.set_in_base(pin));
        for code in begin {
            machine.instr().write(|w| w.set_instr(code));
        }
    }
    PIO0.ctrl().modify(|w| w.set_sm_enable(0b111));
}

/// Latches the counts; called from the tick timer's interrupt. Values that wait in the queues are
/// old, so each queue is emptied, and its last value is kept.
pub fn latch() {
    for (number, kept) in LATCHED.iter().enumerate() {
        for _ in 0..QUEUE {
            if PIO0.fstat().read().rxempty() & 1 << number != 0 {
                continue;
            }
            kept.store(PIO0.rxf(number).read(), Ordering::Relaxed);
        }
    }
}

/// Counts of the three encoders, latched at the edge of the tick timer; the controller converts
/// them to a tip position.
pub fn sense() -> Option<Reading> {
    let [x, y, z] = &LATCHED;
    let counts = [x, y, z].map(|kept| EncoderCounts(kept.load(Ordering::Relaxed).cast_signed()));
    let status = if PIO0.ctrl().read().sm_enable() == 0b111 { SensorStatus::Good } else { SensorStatus::Failed };
    let sequence = READINGS.load(Ordering::Relaxed).wrapping_add(1);
    READINGS.store(sequence, Ordering::Relaxed);
    Some(Reading::Joints(JointReading { counts, sequence, status }))
}
