//! Raspberry Pi Pico 2: RP2350, one Cortex-M33 of two, 150 MHz. **Built, never run on hardware.**
//!
//! | what | where |
//! |---|---|
//! | tick, 1 kHz | `SysTick` |
//! | encoders x, y, z | GPIO 2 and 3, 4 and 5, 6 and 7: `PIO0` counts them |
//! | magnitude x, y, z | GPIO 16, 18, 20 (PWM slices 0 to 2), 20 kHz: low is no force |
//! | direction x, y, z | GPIO 17, 19, 21, high is toward the negative side |
//! | enable line | GPIO 22, high is on |
//! | stop circuit | GPIO 28, high is closed, low or open stops |
//! | supply of the amplifiers, operator's switch | GPIO 26, 27, high is good and pressed |
//! | link | UART0 (GPIO 0, 1), 921 600 baud, to a USB adapter or a debug probe |
//! | light | GPIO 25 |
//! | watchdog | 4.5 ms, on the crystal |
//!
//! **No hardware break.** The timers of this chip have no input that switches the outputs off, so
//! the stop circuit is read once per tick. The circuit has to cut the amplifiers' enable line by
//! itself.
//!
//! **Pull-downs.** Erratum RP2350-E9: the chip's own pull-downs do not hold an open input low on
//! its first steppings. Stop circuit, supply and operator's switch need 4.7 kOhm to ground on the
//! board.
//!
//! The tick runs from RAM and the patch is read from RAM (`build/memory.rs`), because the flash is
//! serial.

use core::sync::atomic::{AtomicI16, Ordering};

use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{DWT, SYST};
use cortex_m_rt::exception;
use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_rp::clocks::clk_sys_freq;
use embassy_rp::gpio::{Input, Level, Output, Pin, Pull};
use embassy_rp::interrupt::{InterruptExt, Priority};
use embassy_rp::pac::io::vals::Outover;
use embassy_rp::pac::{self, IO_BANK0, PWM, SIO, UART0, WATCHDOG};
use embassy_rp::pwm::{Config, Pwm};
use embassy_rp::uart::Uart;
use embassy_rp::{Peri, interrupt};
use palpate::Fault;
use palpate_controller::board::WATCHDOG_US;
use palpate_controller::force_out::bridge::{AxisPins, Bridge, Line, Pins, StopCircuit};
use palpate_controller::force_out::{DacCode, Outputs};
use palpate_controller::link::BAUD;
use palpate_controller::patch::Budget;

#[cfg(not(feature = "self-test"))]
pub use super::flashed::duty;
pub use super::flashed::{after_crash, debug_start, debug_write, exit, idle, print};
pub use super::queues::room as link_room;
use super::{SETTLES_HZ, by_interrupt, fast_memory, queues};
use crate::period;

mod encoders;
pub mod profile_slots;
pub use encoders::sense;

/// Board and version, for hosts.
pub const NAME: &str = concat!("pico2 ", env!("CARGO_PKG_VERSION"));
const TICK_HZ: u32 = 1_000;
const MAGNITUDES: [usize; 3] = [16, 18, 20];
const DIRECTIONS: [usize; 3] = [17, 19, 21];
const ENABLE: usize = 22;
const SUPPLY: usize = 26;
const OPERATOR: usize = 27;
const STOP: usize = 28;
/// Steps per PWM period: 20 kHz at 150 MHz.
const PERIOD_STEPS: u16 = 7_500;

static HAPTIC: InterruptExecutor = InterruptExecutor::new();
static BACKGROUND: InterruptExecutor = InterruptExecutor::new();
/// Converter codes last written.
static CODES: [AtomicI16; 3] = [const { AtomicI16::new(0) }; 3];

#[interrupt]
unsafe fn SWI_IRQ_0() {
    // SAFETY: the executor's own interrupt, which nothing else uses.
    unsafe { HAPTIC.on_interrupt() }
}

#[interrupt]
unsafe fn SWI_IRQ_1() {
    // SAFETY: as above.
    unsafe { BACKGROUND.on_interrupt() }
}

#[exception]
fn SysTick() {
    encoders::latch();
    period::on_period();
}

/// Sets up memories, clocks and pins, with the outputs off, and starts the executors.
pub fn start_executors() -> (SendSpawner, SendSpawner) {
    fast_memory::load();
    let p = embassy_rp::init(embassy_rp::config::Config::default());
    output(p.PIN_22);
    output(p.PIN_17);
    output(p.PIN_19);
    output(p.PIN_21);
    output(p.PIN_25);
    input(p.PIN_26);
    input(p.PIN_27);
    input(p.PIN_28);
    let mut period = Config::default();
    period.top = PERIOD_STEPS - 1;
    core::mem::forget(Pwm::new_output_a(p.PWM_SLICE0, p.PIN_16, period.clone()));
    core::mem::forget(Pwm::new_output_a(p.PWM_SLICE1, p.PIN_18, period.clone()));
    core::mem::forget(Pwm::new_output_a(p.PWM_SLICE2, p.PIN_20, period));
    for pin in MAGNITUDES {
        // after a reset a pad's input is disabled, and its level could not be read back
        pac::PADS_BANK0.gpio(pin).modify(|w| w.set_ie(true));
    }
    outputs_off();
    encoders::start([p.PIN_2.into(), p.PIN_3.into(), p.PIN_4.into(), p.PIN_5.into(), p.PIN_6.into(), p.PIN_7.into()]);
    let mut link = embassy_rp::uart::Config::default();
    link.baudrate = BAUD;
    core::mem::forget(Uart::new_blocking(p.UART0, p.PIN_0, p.PIN_1, link));
    UART0.uartimsc().write(|w| {
        w.set_rxim(true);
        w.set_rtim(true); // also for fewer bytes than the level that raises the other one
    });
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
        // SAFETY: no critical section in this image is built on priority masking (BASEPRI).
        unsafe {
            core.SCB.set_priority(SystemHandler::SysTick, 0x20);
            core.NVIC.set_priority(interrupt::UART0_IRQ, 0x30); // above the haptic loop
            interrupt::UART0_IRQ.enable();
        }
    }
    interrupt::SWI_IRQ_0.set_priority(Priority::P1);
    interrupt::SWI_IRQ_1.set_priority(Priority::P2);
    (HAPTIC.start(interrupt::SWI_IRQ_0), BACKGROUND.start(interrupt::SWI_IRQ_1))
}

/// Makes a pin an output that is low.
fn output(pin: Peri<'static, impl Pin>) {
    core::mem::forget(Output::new(pin, Level::Low));
}

/// Makes a pin an input that reads low if its wire is open.
fn input(pin: Peri<'static, impl Pin>) {
    core::mem::forget(Input::new(pin, Pull::Down));
}

/// Starts the 1 kHz timer, above both executors, and the watchdog.
pub fn start_tick_timer() {
    // SAFETY: SysTick is used by this file only; `take` in `start_executors` takes the other core
    // peripherals.
    let mut timer = unsafe { cortex_m::Peripherals::steal() }.SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(clock_hz() / TICK_HZ - 1);
    timer.clear_current();
    timer.enable_interrupt();
    timer.enable_counter();
    // the watchdog resets everything except the oscillators
    pac::PSM.wdsel().write_value(pac::psm::regs::Wdsel(0x01FF_FFFF & !0b1100));
    WATCHDOG.ctrl().modify(|w| w.set_enable(false));
    feed_watchdog();
    WATCHDOG.ctrl().modify(|w| {
        // outputs keep pulsing while a debugger halts the core, so the watchdog has to act
        w.set_pause_dbg0(false);
        w.set_pause_dbg1(false);
        w.set_pause_jtag(false);
        w.set_enable(true);
    });
}

/// Feeds the watchdog; called after a completed and checked tick.
pub fn feed_watchdog() {
    WATCHDOG.load().write_value(pac::watchdog::regs::Load(WATCHDOG_US));
}

/// Core clock [Hz].
pub fn clock_hz() -> u32 {
    clk_sys_freq()
}

/// Core cycles since the tick timer's last edge. The timer counts down.
pub fn since_period_counts() -> u32 {
    (clock_hz() / TICK_HZ - 1).saturating_sub(SYST::get_current())
}

/// Core cycles; wraps every 28 s.
pub fn clock_counts() -> u32 {
    DWT::cycle_count()
}

/// A span of [`clock_counts`] in nanoseconds; saturates at 4.3 s.
pub fn counts_to_ns(counts: u32) -> u32 {
    u32::try_from(u64::from(counts) * 1_000 / u64::from(clock_hz() / 1_000_000)).unwrap_or(u32::MAX)
}

defmt::timestamp!("{=u32:ms}", period::periods_begun());

fn is_high(pin: usize) -> bool {
    SIO.gpio_in(0).read() & 1 << pin != 0
}

fn set(pin: usize, high: bool) {
    let output = SIO.gpio_out(0);
    if high { output.value_set().write_value(1 << pin) } else { output.value_clr().write_value(1 << pin) }
}

fn line(pin: usize) -> Line {
    Line { register: SIO.gpio_out(0).value().read() & 1 << pin != 0, level: is_high(pin) }
}

fn is_open(pin: usize) -> bool {
    IO_BANK0.gpio(pin).ctrl().read().outover() != Outover::LOW
}

/// Lets the magnitudes' pulses through, or holds their pins low regardless of the timers.
fn pass(on: bool) {
    for pin in MAGNITUDES {
        IO_BANK0.gpio(pin).ctrl().modify(|w| w.set_outover(if on { Outover::NORMAL } else { Outover::LOW }));
    }
}

/// No timer of this chip latches a trip, so only the present level counts.
fn stop_circuit() -> StopCircuit {
    StopCircuit { tripped: false, closed: is_high(STOP) }
}

/// Writes the codes to the bridges and sets the enable line. The line is switched off before the
/// codes change, and on after they have changed.
pub fn write_outputs(outputs: Outputs) {
    if !outputs.enabled {
        set(ENABLE, false);
        pass(false);
    }
    for (axis, (code, kept)) in outputs.codes.into_iter().zip(&CODES).enumerate() {
        let (next, channel) = (Bridge::of(code, PERIOD_STEPS), PWM.ch(axis));
        if Bridge::of(DacCode(kept.load(Ordering::Relaxed)), PERIOD_STEPS).passes_zero(next) {
            // a new pulse length takes effect at the end of a period: end the period now, so that
            // no pulse outlives its direction
            channel.cc().modify(|w| w.set_a(0));
            channel.ctr().write(|w| w.set_ctr(PERIOD_STEPS - 1));
        }
        set(DIRECTIONS[axis], next.reverse);
        channel.cc().modify(|w| w.set_a(next.steps));
        kept.store(code.0, Ordering::Relaxed);
    }
    if outputs.enabled && stop_circuit().allows_outputs() {
        pass(true);
        set(ENABLE, true);
    }
}

/// Reads the outputs back, by pin levels and by the registers that drive them, once they have
/// settled.
pub fn outputs() -> Outputs {
    cortex_m::asm::delay(clock_hz() / SETTLES_HZ);
    let axes = core::array::from_fn(|axis| AxisPins {
        steps: PWM.ch(axis).cc().read().a(),
        pwm_level: is_high(MAGNITUDES[axis]),
        reverse: line(DIRECTIONS[axis]),
    });
    let pins = Pins { enable: line(ENABLE), main_output: MAGNITUDES.into_iter().any(is_open), axes };
    let [x, y, z] = &CODES;
    pins.outputs([x, y, z].map(|kept| DacCode(kept.load(Ordering::Relaxed))), PERIOD_STEPS)
}

/// Releases the force. Takes no lock and calls nothing that can fail.
#[inline(never)]
pub fn outputs_off() {
    write_outputs(Outputs::OFF);
}

/// Whether the outputs are off before anything is switched on.
pub fn healthy() -> bool {
    outputs() == Outputs::OFF
}

/// Whether the supply's monitor pulls its pin down.
pub fn supply_low() -> bool {
    !is_high(SUPPLY)
}

/// Whether the stop circuit is open.
pub fn emergency_stop() -> Option<Fault> {
    stop_circuit().fault()
}

/// Whether the operator's switch is released.
pub fn operator_absent() -> Option<bool> {
    Some(!is_high(OPERATOR))
}

/// Share of this core's cycles that the budget counts (1): conflicts between code and data in the
/// banks of RAM, and reads of the serial flash, are in no cost.
const WORTH: f32 = 0.8;

/// Cycles that a patch may take per tick: the share of a Cortex-M4F's tick, at this clock.
pub fn budget() -> Budget {
    Budget { cycles: WORTH * Budget::M4F_168.cycles / 168e6 * clock_hz() as f32 }
}

/// Reads the bytes received. The interrupt is pended as well, so that transfers resume in the next
/// tick if it was missed.
pub fn link_read(bytes: &mut [u8]) -> usize {
    interrupt::UART0_IRQ.pend();
    by_interrupt::read(bytes)
}

/// Queues a frame, without blocking, or drops it if it does not fit as a whole.
pub fn link_write(frame: &[u8]) {
    queues::write(frame);
    interrupt::UART0_IRQ.pend();
}

/// Moves all received bytes to their queue, and queued bytes to the UART while it accepts them. An
/// interrupt, because the UART's own queue holds 0.35 ms of bytes.
#[interrupt]
fn UART0_IRQ() {
    by_interrupt::keep(|| (!UART0.uartfr().read().rxfe()).then(|| UART0.uartdr().read().data()));
    let waits = by_interrupt::send(|| !UART0.uartfr().read().txff(), |byte| UART0.uartdr().write(|w| w.set_data(byte)));
    UART0.uartimsc().modify(|w| w.set_txim(waits));
}

/// Unit of [`clock_counts`] in words.
#[cfg(feature = "self-test")]
pub const CLOCK_KIND: &str = "cycles of the core (DWT)";

/// Identification of the chip; its brown-out detector is on after a reset.
#[cfg(feature = "self-test")]
pub fn chip() -> (u32, [u8; 2]) {
    (pac::SYSINFO.chip_id().read().0, [0; 2])
}

/// Turns the board's light on or off.
#[cfg(feature = "self-test")]
pub fn led(on: bool) {
    set(25, on);
}

/// Does nothing: the board repeats its report.
#[cfg(feature = "self-test")]
pub fn after_report(_: bool) {}

/// Whether arming is barred after too many crashes.
pub fn barred() -> bool {
    super::resets::barred(WATCHDOG.reason().read().timer())
}
