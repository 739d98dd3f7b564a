//! Modes and faults in words, for logs and hosts.

use palpate::Fault;
use palpate::haptic::mode::Mode;

/// A mode.
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

/// A fault, or the word for none.
#[must_use]
pub fn fault(fault: Option<Fault>) -> &'static str {
    fault.map_or("none", Fault::text)
}
