//! Mode machine: decides in which modes force output is enabled.
//!
//! ```text
//! Boot ─ SelfTest ─ Idle ─ Arming ─ Active ⇄ Degraded       any ─ Fault ─ (cleared) ─ SelfTest
//!                     ↑                 └── SafeRamp ──┘
//!                     └──────────────────────┘
//! ```
//!
//! Force in `Active` and `Degraded`, a falling one in `SafeRamp`, exactly none elsewhere. A force
//! begins in `Arming` only: whatever ended the last one, the next begins there, outside the tissue.
//! A host that falls silent, a stop, or an operator who lets go of the hand switch or leaves the
//! pedal ramps the force down, for the pose can still be trusted; anything that makes pose, model
//! or actuator doubtful leads to `Fault` at once. The loop cannot be armed while the operator is
//! absent, and does not arm by itself when the operator returns: arming has to be requested again.
//!
//! * in: events
//! * out: the mode, the first fault
//! * cost: one search through [`TRANSITIONS`] per event
//! * may fail: never; an event that a mode does not accept changes nothing

use crate::fault::Fault;

/// Operating mode of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Mode {
    /// Power came on.
    Boot = 0,
    /// Sensors and actuators are tried.
    SelfTest = 1,
    /// No force; patches and configuration are accepted.
    Idle = 2,
    /// The patch answers poses and no force is output, until the probe is calm outside the tissue.
    Arming = 3,
    /// The force is felt.
    Active = 4,
    /// The force is felt, scaled down for the rest of this contact.
    Degraded = 5,
    /// The force is felt while it falls to zero.
    SafeRamp = 6,
    /// No force until cleared.
    Fault = 7,
}

impl Mode {
    /// Every mode.
    pub const ALL: [Self; 8] =
        [Self::Boot, Self::SelfTest, Self::Idle, Self::Arming, Self::Active, Self::Degraded, Self::SafeRamp, Self::Fault];

    /// Whether the patch runs.
    #[must_use]
    pub fn runs_patch(self) -> bool {
        matches!(self, Self::Arming | Self::Active | Self::Degraded | Self::SafeRamp)
    }

    /// Whether a force may leave.
    #[must_use]
    pub fn allows_force(self) -> bool {
        matches!(self, Self::Active | Self::Degraded | Self::SafeRamp)
    }

    /// Whether a request may be followed now.
    #[must_use]
    pub fn accepts(self, request: Request) -> bool {
        match request {
            Request::Mesh | Request::Config => self == Self::Idle,
            Request::Parameter => matches!(self, Self::Idle | Self::Active | Self::Degraded),
            Request::LowerLimits => true,
        }
    }
}

/// Messages that are accepted in a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Another patch.
    Mesh,
    /// Another profile, damping, limits.
    Config,
    /// A bounded change of one parameter of the patch.
    Parameter,
    /// Stricter limits.
    LowerLimits,
}

/// Event that may change the mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Memory, clock and patch are there.
    Booted,
    /// Sensors and actuators passed.
    TestPassed,
    /// Arming was requested.
    ArmAsked,
    /// All arming conditions held for their time.
    Armed,
    /// A stop was requested.
    StopAsked,
    /// The host fell silent.
    HostLost,
    /// The operator let go of the hand switch or left the pedal.
    OperatorLeft,
    /// The contact was at the force limit for long, or it created energy.
    Strained,
    /// The contact that was scaled down is over.
    Recovered,
    /// The falling force is zero.
    RampEnded,
    /// Any fault.
    Faulted,
    /// The fault was cleared by request, and poses have been good since.
    Cleared,
}

impl Event {
    /// Every event.
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

/// The machine: a mode, how long it has lasted, and the fault that ended it.
#[derive(Clone, Copy, Debug)]
pub struct ModeMachine {
    mode: Mode,
    fault: Option<Fault>,
    ticks: u32,
}

impl ModeMachine {
    /// Just powered.
    pub const BOOT: Self = Self { mode: Mode::Boot, fault: None, ticks: 0 };

    /// The mode.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The first fault since the last clearing, or the emergency stop that followed it.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Ticks begun in this mode.
    #[must_use]
    pub fn ticks(&self) -> u32 {
        self.ticks
    }

    /// A tick begins.
    pub fn count(&mut self) {
        self.ticks = self.ticks.saturating_add(1);
    }

    /// Follows an event other than a fault; false if the mode does not accept it.
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

    /// Stops everything for this reason. A fault that is already there stays, except that an
    /// emergency stop replaces it: as long as it acts, clearing the other one does not help.
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
