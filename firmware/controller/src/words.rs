//! Modes and faults as text, for logs and hosts.

use palpate::Fault;
use palpate::haptic::mode::Mode;

/// The mode in lower case, as logs and `palpate board` print it.
#[must_use]
pub fn mode(mode: Mode) -> &'static str {
    match mode {
        Mode::Boot => "boot",
        Mode::SelfTest => "self-test",
        Mode::Idle => "idle",
        Mode::Arming => "arming",
        Mode::Active => "active",
        Mode::Degraded => "degraded",
        Mode::SafeRamp => "safe ramp",
        Mode::Fault => "fault",
    }
}

/// The text of a fault, or "none".
#[must_use]
pub fn fault(fault: Option<Fault>) -> &'static str {
    fault.map_or("none", Fault::text)
}
