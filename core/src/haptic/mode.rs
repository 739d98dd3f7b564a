//! Mode machine: decides in which modes force output is enabled.
//!
//! ```text
//! Boot ─ SelfTest ─ Idle ─ Arming ─ Active ⇄ Degraded       any ─ Fault ─ (cleared) ─ SelfTest
//!                     ↑                 └── SafeRamp ──┘
//!                     └──────────────────────┘
//! ```
//!
//! A force acts in `Active` and `Degraded`, a falling one in `SafeRamp`, and none in the other
//! modes. A force begins through `Arming` only: whatever ended the last force, the next one begins
//! there, outside the tissue. The force is ramped down if the host falls silent, if a stop is
//! requested, or if the operator lets go of the hand switch or leaves the pedal, because the pose
//! can still be trusted then. Anything that makes pose, model or actuator doubtful leads to `Fault`
//! at once. The loop cannot be armed while the operator is absent, and it does not arm by itself
//! when the operator returns: arming has to be requested again.
//!
//! * in: events
//! * out: the mode, the first fault
//! * cost: one search through [`TRANSITIONS`] per event
//! * failures: none; an event that a mode does not accept changes nothing

use crate::fault::Fault;

/// Operating mode of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Mode {
    /// Power has just come on.
    Boot = 0,
    /// Sensors and actuators are being tested.
    SelfTest = 1,
    /// No force; patches and configuration are accepted.
    Idle = 2,
    /// The patch answers poses but no force is output, until the probe has been calm outside the
    /// tissue.
    Arming = 3,
    /// The force is output.
    Active = 4,
    /// The force is output, scaled down for the rest of this contact.
    Degraded = 5,
    /// The force is output while it falls to zero.
    SafeRamp = 6,
    /// There is no force until the fault is cleared.
    Fault = 7,
}

impl Mode {
    /// All modes in the order of their numbers.
    pub const ALL: [Self; 8] =
        [Self::Boot, Self::SelfTest, Self::Idle, Self::Arming, Self::Active, Self::Degraded, Self::SafeRamp, Self::Fault];

    /// Whether the patch runs.
    #[must_use]
    pub fn runs_patch(self) -> bool {
        matches!(self, Self::Arming | Self::Active | Self::Degraded | Self::SafeRamp)
    }

    /// Whether a force may be output.
    #[must_use]
    pub fn allows_force(self) -> bool {
        matches!(self, Self::Active | Self::Degraded | Self::SafeRamp)
    }

    /// Whether a request of the host may be followed in this mode.
    #[must_use]
    pub fn accepts(self, request: Request) -> bool {
        match request {
            Request::Mesh | Request::Config => self == Self::Idle,
            Request::Parameter => matches!(self, Self::Idle | Self::Active | Self::Degraded),
            Request::LowerLimits => true,
        }
    }
}

/// Requests of the host that are accepted in some modes only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// The host sends another patch.
    Mesh,
    /// The host sends another device profile, damping or limits.
    Config,
    /// A bounded change of one parameter of the patch.
    Parameter,
    /// The host sends stricter limits.
    LowerLimits,
}

/// Event that may change the mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Memory, clock and patch are ready.
    Booted,
    /// Sensors and actuators passed the test.
    TestPassed,
    /// Arming was requested.
    ArmAsked,
    /// All arming conditions have held long enough.
    Armed,
    /// A stop was requested.
    StopAsked,
    /// The host fell silent.
    HostLost,
    /// The operator let go of the hand switch or left the pedal.
    OperatorLeft,
    /// The contact was at the force limit for too long, or its force fades at rest.
    Strained,
    /// The contact that was scaled down is over.
    Recovered,
    /// The falling force is zero.
    RampEnded,
    /// A fault of any kind occurred.
    Faulted,
    /// The fault was cleared by request, and poses have been good since.
    Cleared,
}

impl Event {
    /// All events in the order of their declaration.
    pub const ALL: [Self; 12] = [
        Self::Booted,
        Self::TestPassed,
        Self::ArmAsked,
        Self::Armed,
        Self::StopAsked,
        Self::HostLost,
        Self::OperatorLeft,
        Self::Strained,
        Self::Recovered,
        Self::RampEnded,
        Self::Faulted,
        Self::Cleared,
    ];
}

/// Every transition between modes. No other transition exists.
pub const TRANSITIONS: [(Mode, Event, Mode); 24] = [
    (Mode::Boot, Event::Booted, Mode::SelfTest),
    (Mode::SelfTest, Event::TestPassed, Mode::Idle),
    (Mode::Idle, Event::ArmAsked, Mode::Arming),
    (Mode::Arming, Event::Armed, Mode::Active),
    (Mode::Arming, Event::StopAsked, Mode::Idle),
    (Mode::Arming, Event::HostLost, Mode::Idle),
    (Mode::Arming, Event::OperatorLeft, Mode::Idle),
    (Mode::Active, Event::Strained, Mode::Degraded),
    (Mode::Active, Event::StopAsked, Mode::SafeRamp),
    (Mode::Active, Event::HostLost, Mode::SafeRamp),
    (Mode::Active, Event::OperatorLeft, Mode::SafeRamp),
    (Mode::Degraded, Event::Recovered, Mode::Active),
    (Mode::Degraded, Event::StopAsked, Mode::SafeRamp),
    (Mode::Degraded, Event::HostLost, Mode::SafeRamp),
    (Mode::Degraded, Event::OperatorLeft, Mode::SafeRamp),
    (Mode::SafeRamp, Event::RampEnded, Mode::Idle),
    (Mode::Boot, Event::Faulted, Mode::Fault),
    (Mode::SelfTest, Event::Faulted, Mode::Fault),
    (Mode::Idle, Event::Faulted, Mode::Fault),
    (Mode::Arming, Event::Faulted, Mode::Fault),
    (Mode::Active, Event::Faulted, Mode::Fault),
    (Mode::Degraded, Event::Faulted, Mode::Fault),
    (Mode::SafeRamp, Event::Faulted, Mode::Fault),
    (Mode::Fault, Event::Cleared, Mode::SelfTest),
];

/// The mode that an event leads to; `None` if the present mode does not accept it.
#[must_use]
pub fn next(mode: Mode, event: Event) -> Option<Mode> {
    TRANSITIONS.iter().find(|(from, on, _)| (*from, *on) == (mode, event)).map(|&(_, _, to)| to)
}

/// State machine of the mode: the present mode, how long it has lasted, and the latched fault.
#[derive(Clone, Copy, Debug)]
pub struct ModeMachine {
    mode: Mode,
    fault: Option<Fault>,
    ticks: u32,
}

impl ModeMachine {
    /// State at power-on.
    pub const BOOT: Self = Self { mode: Mode::Boot, fault: None, ticks: 0 };

    /// Mode after the last event.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The first fault since the last clearing, or an emergency stop that replaced it.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Number of ticks begun in this mode.
    #[must_use]
    pub fn ticks(&self) -> u32 {
        self.ticks
    }

    /// Counts one tick in this mode.
    pub fn count(&mut self) {
        self.ticks = self.ticks.saturating_add(1);
    }

    /// Follows an event other than a fault; returns false if the mode does not accept it.
    pub fn handle(&mut self, event: Event) -> bool {
        match next(self.mode, event) {
            Some(mode) if event != Event::Faulted => {
                if self.mode == Mode::Fault {
                    self.fault = None;
                }
                (self.mode, self.ticks) = (mode, 0);
                true
            }
            _ => false,
        }
    }

    /// Enters `Fault` for this reason. A fault that is already latched stays, except that an
    /// emergency stop replaces it: while the stop acts, clearing the other fault does not help.
    pub fn fail(&mut self, fault: Fault) {
        if let Some(mode) = next(self.mode, Event::Faulted) {
            (self.mode, self.ticks, self.fault) = (mode, 0, Some(fault));
        } else if fault == Fault::EmergencyStop {
            self.fault = Some(fault);
        }
    }
}

#[cfg(test)]
mod tests;
