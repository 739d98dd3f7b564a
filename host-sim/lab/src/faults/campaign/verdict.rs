//! Decides whether the required reaction followed.

use palpate::haptic::cycle::Telemetry;
use palpate::haptic::mode::Mode;
use palpate::{Fault, Vector3};

use super::case::Case;
use super::state::Outcome;
use crate::faults::faulty::Expected;

/// Whether this tick shows the required reaction.
pub(super) fn reacted(expected: &Expected, telemetry: &Telemetry) -> bool {
    match expected {
        Expected::Ramp(_) => matches!(telemetry.mode, Mode::SafeRamp | Mode::Idle),
        // a renderer that still returns a force after that force has pushed the probe out is
        // detected by the comparison of the shown tip with the sensed one
        Expected::Degraded(_) => telemetry.mode == Mode::Degraded || telemetry.fault == Some(Fault::TipApart),
        _ => telemetry.mode == Mode::Fault && telemetry.applied_n == Vector3::zeros(),
    }
}

/// Returns the deviation from the required reaction, if any; `mode` is the mode in the last tick.
pub(super) fn verdict(case: &Case, outcome: &Outcome, mode: Mode) -> Option<&'static str> {
    let (fault, reaction) = (outcome.fault, outcome.reaction_ticks);
    let in_time = |within: u32| reaction.is_some_and(|r| r <= within);
    let wrong = |what, holds: bool| (!holds).then_some(what);
    if !outcome.injected {
        return wrong("a fault that nobody injected", fault.is_none());
    }
    match case.kind().expected {
        Expected::Fault(of, within) => wrong("not noticed", fault.is_some())
            .or(wrong("noticed as something else", fault.is_some_and(|f| of.contains(&f))))
            .or(wrong("noticed too late", in_time(within))),
        Expected::Ridden => wrong("a false alarm", fault.is_none())
            .or(wrong("the force was taken away", matches!(mode, Mode::Active | Mode::Degraded))),
        Expected::Bounded(of) => wrong("ended by another fault", fault.is_none_or(|f| of.contains(&f))),
        Expected::Ramp(within) => wrong("a fault instead of a ramp", fault.is_none()).or(wrong("ramp too late", in_time(within))),
        Expected::Degraded(within) => wrong("not scaled down", in_time(within)),
        Expected::Nothing => None,
    }
}
