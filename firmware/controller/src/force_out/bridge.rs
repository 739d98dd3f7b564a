//! Sign-and-magnitude drive: one PWM pin and one direction pin per axis, and the check of their
//! levels and registers.
//!
//! If half of the period meant "no force", a timer would have to run for it, and a stopped timer or
//! a floating pin would mean full force in one direction. Here a low PWM pin means no force: a
//! stopped timer, a released pin with a pull-down and a hardware break all leave it low. The
//! direction pin alone produces no force.

use palpate::Fault;

use super::{DacCode, Outputs};

/// Command to the bridge of one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bridge {
    /// Steps of the PWM period for which the pin is high; 0 is no force.
    pub steps: u16,
    /// Direction pin high: force toward the negative side of the axis.
    pub reverse: bool,
}

impl Bridge {
    /// The pins for a code; the pulse of the largest code is shorter than the period.
    #[must_use]
    pub fn of(code: DacCode, period_steps: u16) -> Self {
        let magnitude = u32::from(code.0.unsigned_abs().min(0x7FFF));
        let steps = ((magnitude * u32::from(period_steps)) >> 15) as u16;
        Self { steps, reverse: code.0 < 0 && steps > 0 }
    }

    /// Whether a pulse in progress must end before the pins are set to `next`: the direction pin
    /// acts at once, and the pulse would push in the wrong direction; at 0 % the pin is low at
    /// once.
    #[must_use]
    pub fn passes_zero(self, next: Self) -> bool {
        self.steps > 0 && (next.steps == 0 || self.reverse != next.reverse)
    }
}

/// An output pin: its register and its level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    /// Level that the output register asks for.
    pub register: bool,
    /// Level of the pin by its input register.
    pub level: bool,
}

impl Line {
    /// Whether register or level is high.
    #[must_use]
    pub fn any(self) -> bool {
        self.register || self.level
    }

    fn is(self, high: bool) -> bool {
        self.register == high && self.level == high
    }
}

/// Pins of one axis as read back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisPins {
    /// Compare register of the PWM pin.
    pub steps: u16,
    /// Level of the PWM pin now, meaningless while it pulses.
    pub pwm_level: bool,
    /// Direction pin, which reverses the force while it is high.
    pub reverse: Line,
}

/// All output pins as read back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pins {
    /// Enable line of the amplifiers.
    pub enable: Line,
    /// The timer's main output switch: while it is off, every PWM pin is held low.
    pub main_output: bool,
    /// PWM and direction pins of each axis.
    pub axes: [AxisPins; 3],
}

impl Pins {
    /// The outputs that these pins represent: the set values if registers and levels agree with
    /// them, otherwise [`Outputs::UNKNOWN`] codes.
    #[must_use]
    pub fn outputs(&self, written: [DacCode; 3], period_steps: u16) -> Outputs {
        let agree = self.axes.iter().zip(written).all(|(pins, code)| {
            let bridge = Bridge::of(code, period_steps);
            let silent = pins.steps == 0 || !self.main_output;
            pins.steps == bridge.steps && pins.reverse.is(bridge.reverse) && !(silent && pins.pwm_level)
        });
        Outputs { enabled: self.enable.any() || self.main_output, codes: if agree { written } else { Outputs::UNKNOWN } }
    }
}

/// The stop circuit: emergency stop and over-current trip in series, closed is high; an open wire
/// triggers a stop. The timer's break input switches the outputs off without the program, and sets
/// a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StopCircuit {
    /// Whether the timer's break flag is set.
    pub tripped: bool,
    /// Whether the break pin is high.
    pub closed: bool,
}

impl StopCircuit {
    /// Fault that the tick receives. The loop latches it: it is cleared by request only, and not
    /// while the circuit is open.
    #[must_use]
    pub fn fault(self) -> Option<Fault> {
        (self.tripped || !self.closed).then_some(Fault::EmergencyStop)
    }

    /// Whether the break flag may be cleared after it was reported: only while the circuit is
    /// closed.
    #[must_use]
    pub fn clears_flag(self) -> bool {
        self.tripped && self.closed
    }

    /// Whether the outputs may be switched on: not between a trip and the tick that reports it.
    #[must_use]
    pub fn allows_outputs(self) -> bool {
        self.fault().is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: u16 = 12_000;

    fn pins(written: [DacCode; 3], enabled: bool) -> Pins {
        let axes = written.map(|code| {
            let Bridge { steps, reverse } = Bridge::of(code, PERIOD);
            AxisPins { steps, pwm_level: false, reverse: Line { register: reverse, level: reverse } }
        });
        Pins { enable: Line { register: enabled, level: enabled }, main_output: enabled, axes }
    }

    #[test]
    fn no_force_is_a_low_pin_and_both_signs_mirror_each_other() {
        assert_eq!(Bridge::of(DacCode::ZERO, PERIOD), Bridge { steps: 0, reverse: false });
        for code in 1..=i16::MAX {
            let (plus, minus) = (Bridge::of(DacCode(code), PERIOD), Bridge::of(DacCode(-code), PERIOD));
            assert_eq!(plus.steps, minus.steps);
            assert!(plus.steps < PERIOD && !plus.reverse && minus.reverse == (minus.steps > 0));
            let exact = f64::from(code) * f64::from(PERIOD) / 32_768.0;
            assert!(f64::from(plus.steps) <= exact && exact < f64::from(plus.steps) + 1.0, "{code}");
        }
        assert_eq!(Bridge::of(DacCode(i16::MIN), PERIOD), Bridge::of(DacCode(-i16::MAX), PERIOD));
    }

    #[test]
    fn the_pulse_ends_before_the_direction_turns() {
        let of = |code| Bridge::of(DacCode(code), PERIOD);
        assert!(of(900).passes_zero(of(-900)) && of(-900).passes_zero(of(900)) && of(900).passes_zero(of(0)));
        assert!(!of(900).passes_zero(of(500)) && !of(-900).passes_zero(of(-500)));
        for code in [-900, -1, 0, 1, 900] {
            assert!(!of(0).passes_zero(of(code)), "at zero no pulse is in progress: {code}");
        }
    }

    #[test]
    fn pins_that_agree_are_what_was_told_and_a_pulse_may_be_high_or_low() {
        let written = [DacCode(1_000), DacCode(-2_000), DacCode::ZERO];
        let mut read = pins(written, true);
        assert_eq!(read.outputs(written, PERIOD), Outputs { enabled: true, codes: written });
        read.axes[0].pwm_level = true;
        assert_eq!(read.outputs(written, PERIOD), Outputs { enabled: true, codes: written });
        assert_eq!(pins([DacCode::ZERO; 3], false).outputs([DacCode::ZERO; 3], PERIOD), Outputs::OFF);
    }

    #[test]
    fn each_pin_that_disagrees_is_seen_by_its_register_and_by_its_level() {
        let written = [DacCode(1_000), DacCode(-2_000), DacCode::ZERO];
        let wrong: [fn(&mut Pins); 6] = [
            |pins| pins.axes[0].steps += 1,
            |pins| pins.axes[0].reverse.register = true,
            |pins| pins.axes[0].reverse.level = true,
            |pins| pins.axes[1].reverse.level = false,
            |pins| pins.axes[2].pwm_level = true, // high at 0 %
            |pins| {
                pins.main_output = false;
                pins.axes[1].pwm_level = true;
            },
        ];
        for (n, spoil) in wrong.into_iter().enumerate() {
            let mut read = pins(written, true);
            spoil(&mut read);
            assert_eq!(read.outputs(written, PERIOD).codes, Outputs::UNKNOWN, "{n}");
        }
        let off: [fn(&mut Pins); 4] = [
            |pins| pins.enable.level = true, // a stuck or shorted line
            |pins| pins.enable.register = true,
            |pins| pins.main_output = true,
            |pins| pins.axes[2].pwm_level = true,
        ];
        for (n, spoil) in off.into_iter().enumerate() {
            let mut read = pins([DacCode::ZERO; 3], false);
            spoil(&mut read);
            assert_ne!(read.outputs([DacCode::ZERO; 3], PERIOD), Outputs::OFF, "{n}");
        }
    }

    #[test]
    fn a_trip_is_reported_even_if_the_circuit_closed_again_and_an_open_wire_stops() {
        let state = |tripped, closed| StopCircuit { tripped, closed };
        assert_eq!(state(false, true).fault(), None);
        for stopped in [state(true, true), state(true, false), state(false, false)] {
            assert_eq!(stopped.fault(), Some(Fault::EmergencyStop));
            assert!(!stopped.allows_outputs());
        }
        assert!(state(false, true).allows_outputs());
        assert!(state(true, true).clears_flag() && !state(true, false).clears_flag());
    }
}
