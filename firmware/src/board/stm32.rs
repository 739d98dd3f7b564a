//! STM32 boards. Each board adds one file in `stm32/`, which implements [`Stm32Board`]; the board's
//! feature selects the file below, and the chip in `Cargo.toml`. **Built, never run on hardware.**
//!
//! | what | by |
//! |---|---|
//! | tick, 1 kHz | TIM7 |
//! | encoders x, y, z | TIM2, TIM3, TIM4 |
//! | magnitude x, y, z | TIM1 channels 1 to 3, 20 kHz, sign and magnitude: low is no force |
//! | direction x, y, z | pins, high is toward the negative side; alone they move nothing |
//! | stop circuit | `TIM1_BKIN`, high is closed, low or open stops |
//! | enable line | pin, high is on |
//! | supply of the amplifiers | pin, high is good: an open pin reads low |
//! | operator's switch | pin, high is pressed: an open pin reads released; the profile uses it |
//! | link | a USART at the debugger's serial port |
//! | watchdog | IWDG, 4.5 ms, its own clock |
//!
//! The stop circuit is the emergency stop and the over-current trip in series from 3.3 V. It should
//! also cut the amplifiers' power by itself: no pin of a chip can stop a shorted transistor. Enable
//! line and magnitudes need pull-downs at the amplifiers, since the pins of a chip in reset float.

use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_stm32::gpio::{AfType, Flex, Input, Level, Output, OutputType, Pin as AnyPin, Pull, Speed};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::pac::Interrupt;
use embassy_stm32::pac::{TIM7, iwdg::Iwdg, iwdg::vals::Key, usart::Usart};
use embassy_stm32::timer::simple_pwm::PwmPinConfig;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Config, Peri, Peripherals, peripherals, rcc};
use palpate_controller::board::WATCHDOG_US;
use palpate_controller::link::BAUD;
use palpate_controller::patch::Budget;

use super::fast_memory;
#[cfg(not(feature = "self-test"))]
pub use super::flashed::duty;
pub use super::flashed::{after_crash, debug_start, debug_write, exit, idle, print};
use crate::period;

// one row for each board
#[cfg_attr(feature = "nucleo-h743zi", path = "stm32/nucleo_h743zi.rs")]
#[cfg_attr(feature = "nucleo-f446re", path = "stm32/nucleo_f446re.rs")]
#[cfg_attr(feature = "nucleo-g474re", path = "stm32/nucleo_g474re.rs")]
mod this;

mod bridge;
mod encoders;
#[cfg_attr(feature = "dma-link", path = "stm32/dma_link.rs")]
mod link;
mod pin;
pub mod profile_slots;

pub use super::queues::room as link_room;
pub use bridge::{emergency_stop, healthy, outputs, outputs_off, write_outputs};
pub use encoders::sense;
pub use link::{read as link_read, write as link_write};
use pin::Pin;
use this::This;

/// Board and version, for hosts.
pub const NAME: &str = This::NAME;

/// The properties in which the boards of this family differ.
pub trait Stm32Board {
    /// Board and version, separated by a space.
    const NAME: &'static str;
    /// The pins that are read and set individually.
    const PINS: BoardPins;
    /// The link's registers.
    const LINK: Usart;
    /// The link's interrupt, on a core with time for it.
    #[cfg(not(feature = "dma-link"))]
    const LINK_INTERRUPT: Interrupt;
    /// The tick timer's interrupt.
    const TICK_INTERRUPT: Interrupt;
    /// Two interrupts of unused peripherals, for the executors of the haptic loop and of everything
    /// else.
    const EXECUTOR_INTERRUPTS: [Interrupt; 2];
    /// The independent watchdog's registers.
    const WATCHDOG: Iwdg;

    /// Configuration of the clock tree.
    fn clocks() -> Config;
    /// Core clock [Hz].
    fn clock_hz() -> u32;
    /// Identification of the chip, as read from its debug unit, and the brown-out level that is set
    /// and that the clocks need.
    #[cfg(feature = "self-test")]
    fn chip() -> (u32, [u8; 2]);
    /// Claims the pins of encoders, magnitudes, link and stop circuit and starts their peripherals;
    /// sets up the pins that are used individually.
    fn wire(peripherals: Peripherals);
    /// Makes output timer and watchdogs stop while a debugger halts the core.
    fn freeze_with_debugger();
    /// Whether a watchdog caused the last reset; clears the reset flags.
    fn reset_by_watchdog() -> bool;
    /// Turns the caches of core or flash on, which are off after a reset.
    fn start_caches() {}
    /// Discards what the core's cache keeps of the flash, after it has been written.
    fn discard_caches() {}
    /// Starts a second watchdog, where the board needs one.
    fn start_second_watchdog() {}
    /// Feeds the second watchdog.
    fn feed_second_watchdog() {}
}

/// Pins that are read and set individually.
pub struct BoardPins {
    /// Enable line of the amplifiers.
    pub enable: Pin,
    /// Monitor of the amplifiers' supply (a comparator, or their own "good" output).
    pub supply: Pin,
    /// The operator's switch, high while it is pressed.
    pub operator: Pin,
    /// Stop circuit (`TIM1_BKIN`), high while it is closed.
    pub stop: Pin,
    /// Directions of x, y and z, high toward the negative side.
    pub directions: [Pin; 3],
    /// Magnitudes of x, y and z, on TIM1's channels 1 to 3.
    pub magnitudes: [Pin; 3],
    /// A light-emitting diode of the board.
    #[cfg_attr(not(feature = "self-test"), expect(dead_code, reason = "the self-test's light"))]
    pub led: Pin,
}

static HAPTIC: InterruptExecutor = InterruptExecutor::new();
static BACKGROUND: InterruptExecutor = InterruptExecutor::new();

/// Defines the interrupt handlers; their names depend on the board's chip.
macro_rules! handlers {
    (tick: $tick:ident, haptic: $haptic:ident, background: $background:ident $(, link: $link:ident)?) => {
        #[interrupt]
        unsafe fn $tick() {
            super::on_tick_timer();
        }
        #[interrupt]
        unsafe fn $haptic() {
            // SAFETY: the executor's own interrupt, which nothing else uses.
            unsafe { super::HAPTIC.on_interrupt() }
        }
        #[interrupt]
        unsafe fn $background() {
            // SAFETY: as above.
            unsafe { super::BACKGROUND.on_interrupt() }
        }
        $(#[interrupt]
        unsafe fn $link() {
            super::link::on_interrupt();
        })?
    };
}
use handlers;

fn on_tick_timer() {
    TIM7.sr().write(|w| w.set_uif(false));
    encoders::latch();
    period::on_period();
}

/// Sets up memories, clocks and pins, with the outputs off, and starts the executors.
pub fn start_executors() -> (SendSpawner, SendSpawner) {
    fast_memory::load();
    let peripherals = embassy_stm32::init(This::clocks());
    This::start_caches(); // after the clock set-up, which overwrites the flash's register as a whole
    This::wire(peripherals);
    This::freeze_with_debugger();
    rcc::enable_and_reset::<peripherals::TIM7>();
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        cortex_m::peripheral::DWT::unlock();
        core.DWT.enable_cycle_counter();
    }
    let [haptic, background] = This::EXECUTOR_INTERRUPTS;
    haptic.set_priority(Priority::P4);
    background.set_priority(Priority::P6);
    (HAPTIC.start(haptic), BACKGROUND.start(background))
}

/// Makes a pin an output that is low from the start.
fn output(pin: Peri<'static, impl AnyPin>) {
    core::mem::forget(Output::new(pin, Level::Low, Speed::Low));
}

/// Makes a pin an input that reads low if its wire is open.
fn input(pin: Peri<'static, impl AnyPin>) {
    core::mem::forget(Input::new(pin, Pull::Down));
}

/// Sets up the stop circuit's pin: an alternate function without a driver. Because of the pull-down
/// an open wire stops the outputs.
fn stop_input(pin: Peri<'static, impl AnyPin>, alternate: u8) {
    let mut stop = Flex::new(pin);
    stop.set_as_af_unchecked(alternate, AfType::input(Pull::Down));
    core::mem::forget(stop);
}

/// Configuration of a magnitude's pin, which is low while nothing drives it.
fn pulled_down() -> PwmPinConfig {
    PwmPinConfig { output_type: OutputType::PushPull, speed: Speed::Low, pull: Pull::Down }
}

/// Configuration of the link's USART.
fn link_config() -> embassy_stm32::usart::Config {
    let mut config = embassy_stm32::usart::Config::default();
    config.baudrate = BAUD;
    config
}

/// Sets the watchdog's time; [`start_tick_timer`] starts it.
fn prepare_watchdog<T: embassy_stm32::wdg::Instance>(watchdog: Peri<'static, T>) {
    IndependentWatchdog::new(watchdog, WATCHDOG_US);
}

/// Steps of the tick timer's counter per second, and per tick.
const COUNTER_HZ: u32 = 1_000_000;
const TICK_STEPS: u16 = 1_000;

/// Starts the 1 kHz timer, above both executors, and the watchdog.
pub fn start_tick_timer() {
    let timer_hz = rcc::frequency::<peripherals::TIM7>().0;
    TIM7.psc().write_value((timer_hz / COUNTER_HZ - 1) as u16);
    TIM7.arr().write(|w| w.set_arr(TICK_STEPS - 1));
    // loads the prescaler, since the first period would otherwise last one step; the flag that this
    // sets is not a tick
    TIM7.egr().write(|w| w.set_ug(true));
    TIM7.sr().write(|w| w.set_uif(false));
    TIM7.dier().write(|w| w.set_uie(true));
    This::TICK_INTERRUPT.set_priority(Priority::P2);
    // SAFETY: its handler is `on_tick_timer`, which shares only atomics and critical-section data.
    unsafe { This::TICK_INTERRUPT.enable() };
    TIM7.cr1().write(|w| w.set_cen(true));
    This::WATCHDOG.kr().write(|w| w.set_key(Key::START));
    This::start_second_watchdog();
    feed_watchdog(); // the independent watchdog starts with its longest time
}

/// Feeds the watchdogs; called after a completed and checked tick.
pub fn feed_watchdog() {
    This::WATCHDOG.kr().write(|w| w.set_key(Key::RESET));
    This::feed_second_watchdog();
}

/// Core clock [Hz].
pub fn clock_hz() -> u32 {
    This::clock_hz()
}

/// Core cycles since the tick timer's last edge, with a resolution of a microsecond.
pub fn since_period_counts() -> u32 {
    u32::from(TIM7.cnt().read().cnt()) * (clock_hz() / COUNTER_HZ)
}

/// Core cycles; wraps after 9 s at 480 MHz, later at lower clocks.
pub fn clock_counts() -> u32 {
    cortex_m::peripheral::DWT::cycle_count()
}

/// A span of [`clock_counts`] in nanoseconds; saturates at 4.3 s.
pub fn counts_to_ns(counts: u32) -> u32 {
    u32::try_from(u64::from(counts) * 1_000 / u64::from(clock_hz() / 1_000_000)).unwrap_or(u32::MAX)
}

// ticks, not cycles, which would wrap every few seconds
defmt::timestamp!("{=u32:ms}", period::periods_begun());

/// Whether the supply's monitor pulls its pin down.
pub fn supply_low() -> bool {
    !This::PINS.supply.is_high()
}

/// Whether the operator's switch is released.
pub fn operator_absent() -> Option<bool> {
    Some(!This::PINS.operator.is_high())
}

/// Cycles that a patch may take per tick: the share of a Cortex-M4F's tick, at this clock.
pub fn budget() -> Budget {
    Budget { cycles: Budget::M4F_168.cycles / 168e6 * clock_hz() as f32 }
}

/// Unit of [`clock_counts`] in words.
#[cfg(feature = "self-test")]
pub const CLOCK_KIND: &str = "cycles of the core (DWT)";

/// Identification of the chip by its debug unit, revision in the upper half, device in the lower,
/// and the brown-out level that is set and that the clocks need.
#[cfg(feature = "self-test")]
pub fn chip() -> (u32, [u8; 2]) {
    This::chip()
}

/// Turns the board's light on or off.
#[cfg(feature = "self-test")]
pub fn led(on: bool) {
    This::PINS.led.set(on);
}

/// Does nothing: the board repeats its report.
#[cfg(feature = "self-test")]
pub fn after_report(_: bool) {}

/// Whether arming is barred after too many crashes.
pub fn barred() -> bool {
    super::resets::barred(This::reset_by_watchdog())
}
