//! Arm MPS2 with FPGA image AN386 (Cortex-M4F) or AN500 (Cortex-M7), as QEMU emulates them.
//! Register addresses: Arm DAI0386 and DAI0500.
//!
//! In the emulator every instruction takes the same time, so its clock counts instructions, not
//! hardware cycles.

use core::{
    fmt,
    sync::atomic::{AtomicBool, AtomicI16, AtomicU32, Ordering},
};

use cortex_m::{
    interrupt::InterruptNumber,
    peripheral::{NVIC, Peripherals},
};
use cortex_m_rt::exception;
use embassy_executor::{InterruptExecutor, SendSpawner};
use palpate::Fault;
use palpate_controller::board::WATCHDOG_US;
use palpate_controller::crash::Crash;
use palpate_controller::force_out::{DacCode, Outputs};
use palpate_controller::patch::Budget;
use palpate_controller::probe_in::Reading;
use palpate_controller::serve::Pace;

use super::Duty;
use crate::period;

mod debug;
mod hand;
mod link;
mod profile;
mod uart;
pub use debug::{debug_start, debug_write};
#[cfg(not(feature = "self-test"))]
pub use link::duty;
pub use link::{link_read, link_room, link_write};
pub use profile::{ProfileMemory, kept_profile};

/// Board and version, for hosts.
pub const NAME: &str = concat!("mps2 ", env!("CARGO_PKG_VERSION"));
/// Main clock of the FPGA images [Hz]; timer 0 and the free-running counter both run on it.
const CLOCK_HZ: u32 = 25_000_000;
const TICK_HZ: u32 = 1_000;

// CMSDK APB timer 0
const TIMER0_CTRL: *mut u32 = 0x4000_0000 as *mut u32;
const TIMER0_VALUE: *mut u32 = 0x4000_0004 as *mut u32;
const TIMER0_RELOAD: *mut u32 = 0x4000_0008 as *mut u32;
const TIMER0_INTCLEAR: *mut u32 = 0x4000_000C as *mut u32;
const TIMER_ENABLE_WITH_INTERRUPT: u32 = 1 | 1 << 3;
// CMSDK APB watchdog; its interrupt is the NMI
const WATCHDOG_LOAD: *mut u32 = 0x4000_8000 as *mut u32;
const WATCHDOG_CONTROL: *mut u32 = 0x4000_8008 as *mut u32;
const WATCHDOG_INTCLEAR: *mut u32 = 0x4000_800C as *mut u32;
const WATCHDOG_ENABLE: u32 = 1;
/// FPGAIO light-emitting diodes; the first one is the enable line.
const LEDS: *mut u32 = 0x4002_8000 as *mut u32;
const ENABLE_LED: u32 = 1;
/// FPGAIO free-running counter, 32 bit, running since reset.
const COUNTER: *const u32 = 0x4002_8018 as *const u32;

/// The interrupts in use. 30 and 31 have no source on these images: they are pended by software to
/// run an executor.
#[derive(Clone, Copy)]
#[repr(u16)]
enum Interrupt {
    UartReceived = 0,
    UartSent = 1,
    TickTimer = 8,
    Haptic = 30,
    Background = 31,
}

// SAFETY: `repr(u16)` fixes the numbers, and every one is below the 32 interrupts these images
// have.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

/// Priority of an interrupt; a smaller number preempts a larger one. Only the top three bits are
/// used, as on chips with the fewest priority bits.
const fn priority(interrupt: Interrupt) -> u8 {
    match interrupt {
        Interrupt::TickTimer => 0x20,
        Interrupt::Haptic => 0x40,
        Interrupt::Background => 0x60,
        // the receiver buffers a single byte, so its interrupt preempts the haptic loop; that costs
        // 60 instructions, at most 12 times per tick
        Interrupt::UartReceived => 0x30,
        Interrupt::UartSent => 0x50,
    }
}

unsafe extern "C" {
    fn DefaultHandler();
}

/// Handlers of interrupts 0 to 31.
// SAFETY: the section is where cortex-m-rt's linker script expects the table, the name is the one
// it keeps, and every entry is a handler.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [unsafe extern "C" fn(); 32] = {
    let mut table: [unsafe extern "C" fn(); 32] = [DefaultHandler; 32];
    table[Interrupt::UartReceived as usize] = uart::on_received;
    table[Interrupt::UartSent as usize] = uart::on_sent;
    table[Interrupt::TickTimer as usize] = on_tick_timer;
    table[Interrupt::Haptic as usize] = on_haptic;
    table[Interrupt::Background as usize] = on_background;
    table
};

static HAPTIC: InterruptExecutor = InterruptExecutor::new();
static BACKGROUND: InterruptExecutor = InterruptExecutor::new();

extern "C" fn on_tick_timer() {
    // SAFETY: a write-one-to-clear register of timer 0, which nothing but this file touches.
    unsafe { TIMER0_INTCLEAR.write_volatile(1) };
    period::on_period();
}

extern "C" fn on_haptic() {
    // SAFETY: called from the executor's own interrupt only, which `start` has unmasked.
    unsafe { HAPTIC.on_interrupt() };
}

extern "C" fn on_background() {
    // SAFETY: as in `on_haptic`.
    unsafe { BACKGROUND.on_interrupt() };
}

/// Starts the executor of the haptic loop and, at a lower priority, the one of everything else.
pub fn start_executors() -> (SendSpawner, SendSpawner) {
    for interrupt in [Interrupt::Haptic, Interrupt::Background] {
        set_priority(interrupt);
    }
    (HAPTIC.start(Interrupt::Haptic), BACKGROUND.start(Interrupt::Background))
}

fn set_priority(interrupt: Interrupt) {
    // SAFETY: called before the interrupt is unmasked, from `main` alone, so nothing else uses the
    // NVIC meanwhile.
    let mut nvic = unsafe { Peripherals::steal() }.NVIC;
    // SAFETY: no critical section in this image is built on priority masking (BASEPRI).
    unsafe { nvic.set_priority(interrupt, priority(interrupt)) };
}

/// Reload value of the tick timer, which counts down to zero.
const PERIOD: u32 = CLOCK_HZ / TICK_HZ - 1;

/// Counts of [`clock_counts`] since the tick timer's last edge.
pub fn since_period_counts() -> u32 {
    // SAFETY: a read without side effects, of a timer that nothing but this file touches.
    PERIOD - unsafe { TIMER0_VALUE.read_volatile() }.min(PERIOD)
}

/// Starts the 1 kHz timer, and the watchdog of the loop that it drives.
pub fn start_tick_timer() {
    set_priority(Interrupt::TickTimer);
    // SAFETY: timer 0 belongs to this file; its handler is in the table above.
    unsafe {
        TIMER0_RELOAD.write_volatile(PERIOD);
        TIMER0_VALUE.write_volatile(PERIOD);
        TIMER0_CTRL.write_volatile(TIMER_ENABLE_WITH_INTERRUPT);
        NVIC::unmask(Interrupt::TickTimer);
    }
    // SAFETY: the watchdog belongs to this file; its handler is `NonMaskableInt` below.
    unsafe {
        WATCHDOG_LOAD.write_volatile(WATCHDOG_US * (CLOCK_HZ / 1_000_000));
        WATCHDOG_CONTROL.write_volatile(WATCHDOG_ENABLE);
    }
}

/// Time at which the watchdog was last fed [counts].
static FED: AtomicU32 = AtomicU32::new(0);

/// Feeds the watchdog; called after a completed and checked tick.
pub fn feed_watchdog() {
    FED.store(now(), Ordering::Relaxed);
    // SAFETY: any write reloads the watchdog, which nothing but this file touches.
    unsafe { WATCHDOG_INTCLEAR.write_volatile(1) };
}

/// The free-running clock; wraps every 171 s.
#[cfg_attr(feature = "stage-cost", inline(never))]
pub fn clock_counts() -> u32 {
    now()
}

/// Reads the counter. Inlined, because a cost report would take a function call for the end of the
/// tick.
#[inline(always)]
fn now() -> u32 {
    // SAFETY: a read-only register without side effects.
    unsafe { COUNTER.read_volatile() }
}

/// Frequency of [`clock_counts`] [Hz].
pub fn clock_hz() -> u32 {
    CLOCK_HZ
}

/// A span of [`clock_counts`] in nanoseconds; saturates at 4.3 s.
pub fn counts_to_ns(counts: u32) -> u32 {
    counts.saturating_mul(1_000_000_000 / CLOCK_HZ)
}

defmt::timestamp!("{=u32:us}", clock_counts() / (CLOCK_HZ / 1_000_000));

/// Waits for the next interrupt without sleeping. QEMU counts sleep twice, so 1 ms of the tick
/// timer would be 2 ms of the clock; in its other mode the clock would follow that of the host
/// machine and skip ticks under load. Nops cost the emulation little. In lock-step the core may
/// sleep, since no timer runs.
pub fn idle(duty: &Duty) {
    match duty {
        Duty::Serve(Pace::LockStep) => cortex_m::asm::wfi(),
        _ => (0..32).for_each(|_| cortex_m::asm::nop()),
    }
}

/// These images have no converters; this array replaces their registers.
static DAC: [AtomicI16; 3] = [const { AtomicI16::new(0) }; 3];
/// Commanded state of the enable line. The line itself is a register of the FPGA that can be read
/// back.
static ENABLE: AtomicBool = AtomicBool::new(false);

fn set_enable(on: bool) {
    ENABLE.store(on, Ordering::Relaxed);
    // SAFETY: a register that nothing but this file accesses; a single write, valid in any context.
    unsafe { LEDS.write_volatile(if on { ENABLE_LED } else { 0 }) };
}

/// Whether the enable line was commanded on, or its register says that it is on.
fn enabled() -> bool {
    // SAFETY: a read without side effects.
    ENABLE.load(Ordering::Relaxed) || unsafe { LEDS.read_volatile() } & ENABLE_LED != 0
}

/// Writes the codes to the converters and sets the enable line. The line is switched off before the
/// codes change, and on after they have changed.
pub fn write_outputs(outputs: Outputs) {
    if !outputs.enabled {
        set_enable(false);
    }
    for (register, code) in DAC.iter().zip(outputs.codes) {
        register.store(code.0, Ordering::Relaxed);
    }
    if outputs.enabled {
        set_enable(true);
    }
}

/// Reads back the codes and the register of the enable line.
pub fn outputs() -> Outputs {
    let [x, y, z] = &DAC;
    let codes = [x, y, z].map(|register| DacCode(register.load(Ordering::Relaxed)));
    Outputs { enabled: enabled(), codes }
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

/// Writes one line of plain text to the emulator's standard error; standard output carries the log
/// frames.
pub fn print(line: fmt::Arguments<'_>) {
    semihosting::eprintln!("{line}");
}

/// These images have no supply monitor: the host reports a low supply voltage.
pub fn supply_low() -> bool {
    false
}

/// These images have no stop circuit: the host reports that it is open.
pub fn emergency_stop() -> Option<Fault> {
    None
}

/// These images have no pin for the operator's switch: the host reports its state.
pub fn operator_absent() -> Option<bool> {
    None
}

/// Cycles that a patch may take per tick, by the core that this image runs on.
pub fn budget() -> Budget {
    const PART: u32 = 0xFFF << 4;
    const CORTEX_M7: u32 = 0xC27 << 4;
    // SAFETY: a read-only register of every Cortex-M.
    let part = unsafe { (*cortex_m::peripheral::CPUID::PTR).base.read() } & PART;
    if part == CORTEX_M7 { Budget::M7_480 } else { Budget::M4F_168 }
}

/// These images have no encoders: readings come from the host's messages, or from the emulated
/// hand, if there is one.
pub fn sense() -> Option<Reading> {
    hand::sense()
}

/// On hardware the watchdog resets the board. An emulated run ends instead, so that its caller need
/// not wait, unless its command line asks for the reset.
pub fn after_crash() -> ! {
    if link::restarts() { super::resets::restart() } else { exit(false) }
}

/// Whether arming is barred after too many crashes.
pub fn barred() -> bool {
    super::resets::barred(false) // a reset by this image leaves a mark in RAM
}

/// Unit of [`clock_counts`] in words.
#[cfg(feature = "self-test")]
pub const CLOCK_KIND: &str = "time of an emulator, in which every instruction takes the same: no cycles of any hardware";

/// Identification of the core (CPUID); no brown-out level.
#[cfg(feature = "self-test")]
pub fn chip() -> (u32, [u8; 2]) {
    // SAFETY: a read-only register of every Cortex-M.
    (unsafe { (*cortex_m::peripheral::CPUID::PTR).base.read() }, [0; 2])
}

/// Turns the second light on or off; the first one is the enable line.
#[cfg(feature = "self-test")]
pub fn led(on: bool) {
    // SAFETY: a register that nothing but this file touches; the enable line stays as it is.
    unsafe { LEDS.write_volatile(LEDS.read_volatile() & ENABLE_LED | u32::from(on) << 1) };
}

/// Ends the emulation.
#[cfg(feature = "self-test")]
pub fn after_report(passed: bool) {
    exit(passed);
}

/// Ends the emulation with exit status 0 or 1.
pub fn exit(success: bool) -> ! {
    semihosting::process::exit(i32::from(!success))
}

#[exception]
unsafe fn NonMaskableInt() -> ! {
    outputs_off();
    let silent = clock_counts().wrapping_sub(FED.load(Ordering::Relaxed)) / (CLOCK_HZ / 1_000_000);
    crate::board::stop(&Crash::HUNG, format_args!("watchdog: no tick was completed for silent_us={silent}"))
}
