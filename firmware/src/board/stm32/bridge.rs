//! The outputs: TIM1's three channels as magnitudes, three direction pins, the enable line.
//!
//! **Two independent ways to switch the force off.** One is the enable line. The other is TIM1's
//! main output switch (MOE): the break input clears it in hardware, even if clock or program has
//! stopped, and the magnitudes are then driven low. Break, polarity and idle levels are locked
//! until the next reset.
//!
//! **Read back in every tick**: the levels (IDR) of enable line, directions and, at 0 %,
//! magnitudes, together with the registers that drive them. The level of a pulsing pin cannot be
//! checked, and no current is measured, so a broken amplifier is not detected here.

use core::sync::atomic::{AtomicI16, AtomicU32, Ordering};

use embassy_stm32::pac::{
    TIM1,
    timer::vals::{Bkp, FilterValue, Lock, Ossi, Ossr},
};
use embassy_stm32::time::khz;
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use embassy_stm32::{Peri, peripherals};
use palpate::Fault;
use palpate_controller::force_out::bridge::{AxisPins, Bridge, Pins, StopCircuit};
use palpate_controller::force_out::{DacCode, Outputs};

use super::{Stm32Board, This, clock_hz};
use crate::board::SETTLES_HZ;

/// Codes last written to the converters, and length of the PWM period [steps].
static CODES: [AtomicI16; 3] = [const { AtomicI16::new(0) }; 3];
static PERIOD_STEPS: AtomicU32 = AtomicU32::new(0);

/// A magnitude's pin on a channel of TIM1.
pub type Magnitude<Channel> = PwmPin<'static, peripherals::TIM1, Channel>;

/// Starts the PWM of the magnitudes, with 20 kHz at 0 % and with the main output off.
pub fn start(
    timer: Peri<'static, peripherals::TIM1>,
    x: Magnitude<embassy_stm32::timer::Ch1>,
    y: Magnitude<embassy_stm32::timer::Ch2>,
    z: Magnitude<embassy_stm32::timer::Ch3>,
) {
    let mut pwm = SimplePwm::new(timer, Some(x), Some(y), Some(z), None, khz(20), CountingMode::EdgeAlignedUp);
    PERIOD_STEPS.store(pwm.max_duty_cycle(), Ordering::Relaxed);
    arm_break_input();
    outputs_off();
    for (register, channel) in [(0, 0), (0, 1), (1, 0)] {
        // a compare register acts at once and not at the end of the period, so that a pulse can be
        // ended without a restart of the timer, which would cut the pulses of the other axes; the
        // pulse of the period in which a force is written lies between the old and the new one
        TIM1.ccmr_output(register).modify(|w| w.set_ocpe(channel, false));
    }
    pwm.ch1().enable();
    pwm.ch2().enable();
    pwm.ch3().enable();
    core::mem::forget(pwm);
}

/// Enables the break input, which switches the outputs off without the program. The input cannot be
/// disabled before the next reset.
fn arm_break_input() {
    TIM1.cr2().modify(|w| (0..3).for_each(|channel| w.set_ois(channel, false)));
    #[cfg(break_source)]
    TIM1.af1().modify(|w| w.set_bkine(true));
    TIM1.bdtr().modify(|w| {
        w.set_moe(false);
        w.set_bkp(0, Bkp::ACTIVE_LOW);
        w.set_bke(0, true);
        w.set_bkf(0, FilterValue::NO_FILTER); // without a filter the break acts even without a clock
        w.set_aoe(false);
        // while the main output is off, the pins are driven low, not released
        w.set_ossi(Ossi::IDLE_LEVEL);
        w.set_ossr(Ossr::IDLE_LEVEL);
    });
    // the lock is a separate write, after the settings that it protects
    TIM1.bdtr().modify(|w| w.set_lock(Lock::LEVEL2));
    clear_break_flag(); // the flag was set by the pin's state before the set-up
}

fn clear_break_flag() {
    TIM1.sr().write(|w| {
        w.0 = u32::MAX; // writing ones changes nothing
        w.set_bif(0, false);
    });
}

fn period_steps() -> u16 {
    PERIOD_STEPS.load(Ordering::Relaxed) as u16
}

fn stop_circuit() -> StopCircuit {
    StopCircuit { tripped: TIM1.sr().read().bif(0), closed: This::PINS.stop.is_high() }
}

/// Writes the codes to the bridges and sets the enable line. The line is switched off before the
/// codes change, and on after they have changed.
pub fn write_outputs(outputs: Outputs) {
    if !outputs.enabled {
        This::PINS.enable.set(false);
        TIM1.bdtr().modify(|w| w.set_moe(false));
    }
    for (axis, ((code, kept), pin)) in outputs.codes.into_iter().zip(&CODES).zip(This::PINS.directions).enumerate() {
        let next = Bridge::of(code, period_steps());
        if Bridge::of(DacCode(kept.load(Ordering::Relaxed)), period_steps()).passes_zero(next) {
            TIM1.ccr(axis).write(|w| w.set_ccr(0)); // no pulse outlives its direction
        }
        pin.set(next.reverse);
        TIM1.ccr(axis).write(|w| w.set_ccr(next.steps));
        kept.store(code.0, Ordering::Relaxed);
    }
    if outputs.enabled && stop_circuit().allows_outputs() {
        TIM1.bdtr().modify(|w| w.set_moe(true));
        This::PINS.enable.set(true);
    }
}

/// Reads the outputs back, by pin levels and by the registers that drive them, once they have
/// settled.
pub fn outputs() -> Outputs {
    cortex_m::asm::delay(clock_hz() / SETTLES_HZ);
    let pins = &This::PINS;
    let axes = core::array::from_fn(|axis| AxisPins {
        steps: TIM1.ccr(axis).read().ccr(),
        pwm_level: pins.magnitudes[axis].is_high(),
        reverse: pins.directions[axis].line(),
    });
    let pins = Pins { enable: pins.enable.line(), main_output: TIM1.bdtr().read().moe(), axes };
    let [x, y, z] = &CODES;
    pins.outputs([x, y, z].map(|kept| DacCode(kept.load(Ordering::Relaxed))), period_steps())
}

/// Releases the force. Takes no lock and calls nothing that can fail.
#[inline(never)]
pub fn outputs_off() {
    write_outputs(Outputs::OFF);
}

/// Whether the stop circuit is open, or was open since the last tick. After one report the timer's
/// flag is cleared; from then on the loop's latched fault keeps the outputs off until a request
/// clears it.
pub fn emergency_stop() -> Option<Fault> {
    let circuit = stop_circuit();
    if circuit.clears_flag() {
        clear_break_flag();
    }
    circuit.fault()
}

/// Whether registers and levels of the outputs are off before anything is switched on, and the
/// break input is enabled and locked.
pub fn healthy() -> bool {
    let guard = TIM1.bdtr().read();
    outputs() == Outputs::OFF && guard.bke(0) && !guard.aoe() && guard.lock() == Lock::LEVEL2
}
