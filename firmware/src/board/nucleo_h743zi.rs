//! ST Nucleo-H743ZI: Cortex-M7 at 480 MHz. **Built, never run on hardware.**
//!
//! | what | where |
//! |---|---|
//! | tick, 1 kHz | TIM7 |
//! | encoders x, y, z | TIM2 (PA15, PB3), TIM3 (PC6, PC7), TIM4 (PD12, PD13) |
//! | magnitude x, y, z | TIM1 (PE9, PE11, PE13), 20 kHz, sign and magnitude: low is no force |
//! | direction x, y, z | PF3, PF5, PF10, high is toward the negative side; alone it moves nothing |
//! | stop circuit | `TIM1_BKIN` (PE15), high is closed, low or open stops |
//! | enable line | PF12, high is on |
//! | supply of the amplifiers | PF13, high is good: an open pin reads low |
//! | operator's switch | PF14, high is pressed: an open pin reads released; the profile uses it |
//! | link | USART3 (PD8, PD9): the debugger's serial port, 115 200 baud |
//! | watchdog | IWDG1, 4.5 ms, its own clock |
//!
//! The stop circuit is the emergency stop and the over-current trip in series from 3.3 V. Enable
//! line and magnitudes are to be pulled down at the amplifiers: a resetting chip lets pins float.
//!
//! **Two ways to no force.** The enable line is one. The other is TIM1's main output switch (MOE):
//! the break input clears it in hardware, clock and program running or not, and the magnitudes are
//! then driven low. Break, polarity and idle levels are locked until the next reset. The stop
//! circuit should also cut the amplifiers' power by itself: what a shorted transistor does no pin
//! of this chip can stop.
//!
//! **Read back every tick**: levels (IDR) of enable line, directions and, at 0 %, magnitudes,
//! beside the registers that drive them. A pulsing pin's level says nothing, and no current is
//! measured: a broken amplifier is not seen here.
//!
//! **Encoders** are counters without a time stamp: a reading is as new as the tick, so
//! [`palpate::Fault::PoseStale`] cannot occur here, and a dead encoder reads as a hand that rests.
//! One check is made: each counter still runs in encoder mode.

use core::fmt;
use core::sync::atomic::{AtomicI16, AtomicU32, Ordering};

use defmt_rtt as _;
use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_stm32::gpio::{AfType, Flex, Input, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::pac::gpio::vals::{Idr, Odr};
use embassy_stm32::pac::timer::vals::{Bkp, FilterValue, Lock, Ossi, Ossr, Sms};
use embassy_stm32::pac::{self, iwdg::vals::Key};
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, HSIPrescaler, Pll, PllDiv, PllMul, PllPreDiv, PllSource, Sysclk, VoltageScale,
};
use embassy_stm32::time::khz;
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::qei::Qei;
use embassy_stm32::timer::simple_pwm::{PwmPin, PwmPinConfig, SimplePwm};
use embassy_stm32::usart::{Config as UartConfig, Uart};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Peripherals, interrupt};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use palpate::Fault;
use palpate::haptic::device::SensorStatus;
use palpate_controller::board::WATCHDOG_US;
use palpate_controller::config::{Flash, FlashError, SLOT_BYTES, Slot};
use palpate_controller::force_out::bridge::{AxisPins, Bridge, Line, Pins, StopCircuit};
use palpate_controller::force_out::{DacCode, Outputs};
use palpate_controller::patch::Budget;
use palpate_controller::probe_in::{EncoderCounts, JointReading, Reading, extended};

use super::Duty;
use crate::period;
use palpate_controller::serve::Pace;

/// Board and version, for hosts.
pub const NAME: &str = concat!("nucleo-h743zi ", env!("CARGO_PKG_VERSION"));
/// Core clock [MHz].
const CLOCK_MHZ: u32 = 480;
/// Counts of the clock in a second.
pub const CLOCK_HZ: u32 = CLOCK_MHZ * 1_000_000;
const TICK_HZ: u32 = 1_000;
const ENABLE_PIN: usize = 12;
const SUPPLY_PIN: usize = 13;
const OPERATOR_PIN: usize = 14;
/// Port F.
const DIRECTION_PINS: [usize; 3] = [3, 5, 10];
/// Port E.
const MAGNITUDE_PINS: [usize; 3] = [9, 11, 13];
const STOP_PIN: usize = 15;
/// Time after which a pin has its level: 0.5 us, ten times the slowest edge of the data sheet at 50
/// pF.
const SETTLE_CYCLES: u32 = CLOCK_MHZ / 2;
/// Steps of the tick timer's counter.
const COUNTER_HZ: u32 = 1_000_000;

static HAPTIC: InterruptExecutor = InterruptExecutor::new();
static BACKGROUND: InterruptExecutor = InterruptExecutor::new();
/// Codes last written to the converters, and the length of their period in steps.
static CODES: [AtomicI16; 3] = [const { AtomicI16::new(0) }; 3];
static PERIOD_STEPS: AtomicU32 = AtomicU32::new(0);
/// Encoders count 16 bits; these go on.
static COUNTS: [AtomicU32; 3] = [const { AtomicU32::new(0) }; 3];
static READINGS: AtomicU32 = AtomicU32::new(0);
/// Bytes for the host.
static OUT: Channel<CriticalSectionRawMutex, u8, 1024> = Channel::new();

#[interrupt]
unsafe fn UART7() {
    // SAFETY: the executor's own interrupt, which nothing else uses.
    unsafe { HAPTIC.on_interrupt() }
}

#[interrupt]
unsafe fn UART8() {
    // SAFETY: as above.
    unsafe { BACKGROUND.on_interrupt() }
}

#[interrupt]
unsafe fn TIM7() {
    pac::TIM7.sr().write(|w| w.set_uif(false));
    period::on_period();
}

/// Sets up clocks and pins, outputs off, and starts the executors.
pub fn start_executors() -> (SendSpawner, SendSpawner) {
    let mut config = embassy_stm32::Config::default();
    let rcc = &mut config.rcc;
    rcc.hsi = Some(HSIPrescaler::DIV1);
    rcc.pll1 = Some(Pll {
        source: PllSource::HSI,
        prediv: PllPreDiv::DIV4,
        mul: PllMul::MUL60, // 64 MHz / 4 x 60 / 2
        fracn: None,
        divp: Some(PllDiv::DIV2),
        divq: None,
        divr: None,
    });
    rcc.sys = Sysclk::PLL1_P;
    rcc.ahb_pre = AHBPrescaler::DIV2;
    (rcc.apb1_pre, rcc.apb2_pre) = (APBPrescaler::DIV2, APBPrescaler::DIV2);
    (rcc.apb3_pre, rcc.apb4_pre) = (APBPrescaler::DIV2, APBPrescaler::DIV2);
    rcc.voltage_scale = VoltageScale::Scale0;
    set_up(embassy_stm32::init(config));
    interrupt::UART7.set_priority(Priority::P4);
    interrupt::UART8.set_priority(Priority::P6);
    (HAPTIC.start(interrupt::UART7), BACKGROUND.start(interrupt::UART8))
}

/// Pins and peripherals. Their drivers are left alone afterwards: what runs in fault handlers
/// writes the registers.
fn set_up(p: Peripherals) {
    core::mem::forget(Output::new(p.PF12, Level::Low, Speed::Low));
    core::mem::forget(Input::new(p.PF13, Pull::Down));
    core::mem::forget(Input::new(p.PF14, Pull::Down));
    for direction in [Output::new(p.PF3, Level::Low, Speed::Low), Output::new(p.PF5, Level::Low, Speed::Low)] {
        core::mem::forget(direction);
    }
    core::mem::forget(Output::new(p.PF10, Level::Low, Speed::Low));
    // an alternate function without a driver: the pull-down makes an open wire a stop
    let mut stop = Flex::new(p.PE15);
    stop.set_as_af_unchecked(1, AfType::input(Pull::Down));
    core::mem::forget(stop);
    let low = PwmPinConfig { output_type: OutputType::PushPull, speed: Speed::Low, pull: Pull::Down };
    let x = PwmPin::new_with_config(p.PE9, low);
    let y =
        PwmPin::new_with_config(p.PE11, PwmPinConfig { output_type: OutputType::PushPull, speed: Speed::Low, pull: Pull::Down });
    let z =
        PwmPin::new_with_config(p.PE13, PwmPinConfig { output_type: OutputType::PushPull, speed: Speed::Low, pull: Pull::Down });
    let mut pwm = SimplePwm::new(p.TIM1, Some(x), Some(y), Some(z), None, khz(20), CountingMode::EdgeAlignedUp);
    PERIOD_STEPS.store(pwm.max_duty_cycle(), Ordering::Relaxed);
    arm_break_input();
    outputs_off();
    pwm.ch1().enable();
    pwm.ch2().enable();
    pwm.ch3().enable();
    core::mem::forget(pwm);
    core::mem::forget(Qei::new(p.TIM2, p.PA15, p.PB3, Default::default()));
    core::mem::forget(Qei::new(p.TIM3, p.PC6, p.PC7, Default::default()));
    core::mem::forget(Qei::new(p.TIM4, p.PD12, p.PD13, Default::default()));
    if let Ok(uart) = Uart::new_blocking(p.USART3, p.PD9, p.PD8, UartConfig::default()) {
        core::mem::forget(uart);
        // sixteen bytes deep: 115 200 baud bring twelve in a tick
        pac::USART3.cr1().modify(|w| w.set_ue(false));
        pac::USART3.cr1().modify(|w| w.set_fifoen(true));
        pac::USART3.cr1().modify(|w| w.set_ue(true));
    }
    IndependentWatchdog::new(p.IWDG1, WATCHDOG_US);
    pac::RCC.apb1lenr().modify(|w| w.set_tim7en(true));
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        cortex_m::peripheral::DWT::unlock();
        core.DWT.enable_cycle_counter();
        core.SCB.enable_icache();
    }
}

/// The break input takes the outputs away without the program; nothing can switch it off before the
/// next reset.
fn arm_break_input() {
    let timer = pac::TIM1;
    timer.cr2().modify(|w| (0..3).for_each(|channel| w.set_ois(channel, false)));
    timer.af1().modify(|w| w.set_bkine(true));
    timer.bdtr().modify(|w| {
        w.set_moe(false);
        w.set_bkp(0, Bkp::ACTIVE_LOW);
        w.set_bke(0, true);
        w.set_bkf(0, FilterValue::NO_FILTER); // unfiltered it acts without a clock
        w.set_aoe(false);
        // without main output the pins are driven low, not released
        w.set_ossi(Ossi::IDLE_LEVEL);
        w.set_ossr(Ossr::IDLE_LEVEL);
    });
    // the lock takes effect with the next write and protects what is written before it
    timer.bdtr().modify(|w| w.set_lock(Lock::LEVEL2));
    // what the pin did before it was set up
    timer.sr().write(|w| {
        w.0 = u32::MAX;
        w.set_bif(0, false);
    });
}

/// Starts the 1 kHz timer, above both executors, and the watchdog.
pub fn start_tick_timer() {
    // timers of this bus run at half the core's clock
    pac::TIM7.psc().write_value((CLOCK_MHZ * 1_000_000 / 2 / COUNTER_HZ - 1) as u16);
    pac::TIM7.arr().write(|w| w.set_arr((COUNTER_HZ / TICK_HZ - 1) as u16));
    pac::TIM7.dier().write(|w| w.set_uie(true));
    interrupt::TIM7.set_priority(Priority::P2);
    // SAFETY: its handler is above, and what it touches is made for interrupts.
    unsafe { interrupt::TIM7.enable() };
    pac::TIM7.cr1().write(|w| w.set_cen(true));
    pac::IWDG1.kr().write(|w| w.set_key(Key::START));
}

/// A completed, checked tick.
pub fn feed_watchdog() {
    pac::IWDG1.kr().write(|w| w.set_key(Key::RESET));
}

/// Core cycles since the tick timer's last edge, to a microsecond.
pub fn since_period_counts() -> u32 {
    u32::from(pac::TIM7.cnt().read().cnt()) * CLOCK_MHZ
}

/// Core cycles; wraps every 9 s.
pub fn clock_counts() -> u32 {
    cortex_m::peripheral::DWT::cycle_count()
}

/// A span of [`clock_counts`] in nanoseconds; saturates at 4.3 s.
pub fn counts_to_ns(counts: u32) -> u32 {
    (counts / 12).saturating_mul(12_000 / CLOCK_MHZ)
}

defmt::timestamp!("{=u32:us}", clock_counts() / CLOCK_MHZ);

fn period_steps() -> u16 {
    PERIOD_STEPS.load(Ordering::Relaxed) as u16
}

fn stop_circuit() -> StopCircuit {
    StopCircuit { tripped: pac::TIM1.sr().read().bif(0), closed: pac::GPIOE.idr().read().idr(STOP_PIN) == Idr::HIGH }
}

/// Puts the codes on the bridges and sets the enable line; off goes first, on last.
pub fn write_outputs(outputs: Outputs) {
    if !outputs.enabled {
        pac::GPIOF.bsrr().write(|w| w.set_br(ENABLE_PIN, true));
        pac::TIM1.bdtr().modify(|w| w.set_moe(false));
    }
    let bridge = |code: &AtomicI16| Bridge::of(DacCode(code.load(Ordering::Relaxed)), period_steps());
    let next = outputs.codes.map(|code| Bridge::of(code, period_steps()));
    let passes_zero: [bool; 3] =
        core::array::from_fn(|axis| CODES.get(axis).is_none_or(|code| bridge(code).passes_zero(next[axis])));
    if passes_zero.contains(&true) {
        for (axis, passes) in passes_zero.into_iter().enumerate() {
            if passes {
                pac::TIM1.ccr(axis).write(|w| w.set_ccr(0));
            }
        }
        // compare registers are taken over at the end of a period: end it now, no pulse may outlive
        // its direction
        pac::TIM1.egr().write(|w| w.set_ug(true));
    }
    for ((axis, bridge), pin) in next.into_iter().enumerate().zip(DIRECTION_PINS) {
        pac::GPIOF.bsrr().write(|w| if bridge.reverse { w.set_bs(pin, true) } else { w.set_br(pin, true) });
        pac::TIM1.ccr(axis).write(|w| w.set_ccr(bridge.steps));
    }
    for (kept, code) in CODES.iter().zip(outputs.codes) {
        kept.store(code.0, Ordering::Relaxed);
    }
    if outputs.enabled && stop_circuit().allows_outputs() {
        pac::TIM1.bdtr().modify(|w| w.set_moe(true));
        pac::GPIOF.bsrr().write(|w| w.set_bs(ENABLE_PIN, true));
    }
}

/// Reads the outputs back, by pin levels and by the registers that drive them, once they have
/// settled.
pub fn outputs() -> Outputs {
    cortex_m::asm::delay(SETTLE_CYCLES);
    let (levels, registers) = (pac::GPIOF.idr().read(), pac::GPIOF.odr().read());
    let line = |pin| Line { register: registers.odr(pin) == Odr::HIGH, level: levels.idr(pin) == Idr::HIGH };
    let pulses = pac::GPIOE.idr().read();
    let axes = core::array::from_fn(|axis| AxisPins {
        steps: pac::TIM1.ccr(axis).read().ccr(),
        pwm_level: pulses.idr(MAGNITUDE_PINS[axis]) == Idr::HIGH,
        reverse: line(DIRECTION_PINS[axis]),
    });
    let pins = Pins { enable: line(ENABLE_PIN), main_output: pac::TIM1.bdtr().read().moe(), axes };
    let [x, y, z] = &CODES;
    pins.outputs([x, y, z].map(|kept| DacCode(kept.load(Ordering::Relaxed))), period_steps())
}

/// Releases the force. Takes no lock and calls nothing that can fail.
#[inline(never)]
pub fn outputs_off() {
    write_outputs(Outputs::OFF);
}

/// Whether the monitor of the amplifiers' supply (a comparator, or their own "good" output) pulls
/// its pin down.
pub fn supply_low() -> bool {
    pac::GPIOF.idr().read().idr(SUPPLY_PIN) == pac::gpio::vals::Idr::LOW
}

/// Whether the stop circuit is open, or was since the last tick. Reported once, the timer's flag is
/// cleared: from there on the loop's own fault holds until it is cleared by request, and with it
/// the outputs are off.
pub fn emergency_stop() -> Option<Fault> {
    let circuit = stop_circuit();
    if circuit.clears_flag() {
        pac::TIM1.sr().write(|w| {
            w.0 = u32::MAX; // ones change nothing
            w.set_bif(0, false);
        });
    }
    circuit.fault()
}

/// Whether the operator's switch is released.
pub fn operator_absent() -> Option<bool> {
    Some(pac::GPIOF.idr().read().idr(OPERATOR_PIN) == Idr::LOW)
}

/// Whether registers and levels of the outputs are off before anything is switched on, and the
/// break input still guards them.
pub fn healthy() -> bool {
    let guard = pac::TIM1.bdtr().read();
    outputs() == Outputs::OFF && guard.bke(0) && !guard.aoe() && guard.lock() == Lock::LEVEL2
}

/// Cycles that a patch may take per tick.
pub fn budget() -> Budget {
    Budget::M7_480
}

/// Three encoders; the profile's mechanism makes a tip of them.
pub fn sense() -> Option<Reading> {
    let read = [pac::TIM2.cnt().read() as u16, pac::TIM3.cnt().read().cnt(), pac::TIM4.cnt().read().cnt()];
    let [x, y, z] = &COUNTS;
    let counts = [(x, read[0]), (y, read[1]), (z, read[2])].map(|(kept, now)| {
        let next = extended(EncoderCounts(kept.load(Ordering::Relaxed).cast_signed()), now);
        kept.store(next.0.cast_unsigned(), Ordering::Relaxed);
        next
    });
    let counting = [
        (pac::TIM2.cr1().read().cen(), pac::TIM2.smcr().read().sms()),
        (pac::TIM3.cr1().read().cen(), pac::TIM3.smcr().read().sms()),
        (pac::TIM4.cr1().read().cen(), pac::TIM4.smcr().read().sms()),
    ];
    let good = counting.into_iter().all(|(runs, mode)| runs && mode == Sms::ENCODER_MODE_3);
    let status = if good { SensorStatus::Good } else { SensorStatus::Failed };
    let sequence = READINGS.load(Ordering::Relaxed).wrapping_add(1);
    READINGS.store(sequence, Ordering::Relaxed);
    Some(Reading::Joints(JointReading { counts, sequence, status }))
}

/// Bytes that have come; moves waiting ones on their way, too. Once per tick is often enough for
/// queues of sixteen.
pub fn link_read(bytes: &mut [u8]) -> usize {
    let uart = pac::USART3;
    while uart.isr().read().txe() {
        let Ok(byte) = OUT.try_receive() else { break };
        uart.tdr().write(|w| w.set_dr(byte.into()));
    }
    uart.icr().write(|w| w.set_ore(true));
    bytes.iter_mut().map_while(|byte| uart.isr().read().rxne().then(|| *byte = uart.rdr().read().dr() as u8)).count()
}

/// Puts bytes in the queue. A frame that finds no room is not begun.
pub fn link_write(bytes: &[u8]) {
    if OUT.free_capacity() >= bytes.len() {
        for byte in bytes {
            let _ = OUT.try_send(*byte); // there is room
        }
    }
}

/// Serves a host.
pub fn duty() -> Duty {
    Duty::Serve(Pace::Timed)
}

/// Whether the watchdog has reset the board too often.
pub fn barred() -> bool {
    let by_watchdog = pac::RCC.rsr().read().iwdg1rstf();
    pac::RCC.rsr().modify(|w| w.set_rmvf(true));
    super::resets::barred(by_watchdog)
}

/// Until the next interrupt.
pub fn idle(_: &Duty) {
    cortex_m::asm::wfi();
}

/// Words for the debugger's log; lost without one.
pub fn print(line: fmt::Arguments<'_>) {
    defmt::error!("{}", defmt::Display2Format(&line));
}

/// There is nowhere to go to: the outputs are off, and the watchdog starts anew.
pub fn exit(_: bool) -> ! {
    after_crash()
}

/// Waits for the watchdog's reset.
pub fn after_crash() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

/// No profile is kept on this board yet, the default one holds: erasing its flash takes longer than
/// the watchdog bears, and what a power cut has left half written may read as a bus fault, which
/// nobody has seen on a board.
#[derive(Default)]
pub struct ProfileMemory;

impl Flash for ProfileMemory {
    fn read(&self, _: Slot, bytes: &mut [u8; SLOT_BYTES]) {
        *bytes = [0xFF; SLOT_BYTES];
    }

    fn erase(&mut self, _: Slot) -> Result<(), FlashError> {
        Err(FlashError)
    }

    fn write(&mut self, _: Slot, _: &[u8; SLOT_BYTES]) -> Result<(), FlashError> {
        Err(FlashError)
    }
}
