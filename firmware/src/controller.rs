//! One tick of the controller without its board: the haptic cycle, its device and what a board asks of it by itself. The desktop runs the same.
//!
//! * in: a reading, what the host and the board said since the last tick
//! * out: what the actuators do, a telemetry record
//! * cost: that of [`palpate::haptic::cycle`]
//! * may fail: every [`palpate::Fault`]; the actuators are off then

use palpate::haptic::cycle::{Ask, Command, Cycle, Renderer, Settings, Telemetry};
use palpate::haptic::device::{HapticDevice, Sensed};
use palpate::haptic::limits::LimitValues;
use palpate::haptic::mode::Mode;
use palpate::{BuildError, Fault};

use crate::edge::{Drive, Edge};

/// Whether anybody may arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arming {
    /// By the host's request.
    OnRequest,
    /// As soon as the mode is `Idle`: there is no host.
    ByItself,
    /// Not before somebody has looked at it: the board was reset by its watchdog again and again.
    Barred,
}

/// The controller.
#[derive(Clone, Copy, Debug)]
pub struct Controller {
    cycle: Cycle,
    edge: Edge,
    arming: Arming,
}

impl Controller {
    /// In `Boot`.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the setting.
    pub fn build(settings: &Settings, edge: Edge, arming: Arming) -> Result<Self, BuildError> {
        Ok(Self { cycle: Cycle::build(settings, &edge.limits())?, edge, arming })
    }

    /// The mode.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.cycle.mode()
    }

    /// Starts up anew with other settings and another device; nobody feels anything until it is armed again.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the setting; nothing changes then.
    pub fn restart(&mut self, settings: &Settings, edge: Edge) -> Result<(), BuildError> {
        *self = Self::build(settings, edge, self.arming)?;
        Ok(())
    }

    /// Whether the last pose touched the patch.
    #[must_use]
    pub fn in_contact(&self) -> bool {
        self.cycle.in_contact()
    }

    /// The limits.
    #[must_use]
    pub fn limits(&self) -> &LimitValues {
        self.cycle.limits()
    }

    /// What the actuators do after the last tick.
    #[must_use]
    pub fn drive(&self) -> Drive {
        self.edge.drive()
    }

    /// Makes limits stricter, in any mode.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the limit that would rise; nothing changes then.
    pub fn lower_limits(&mut self, values: &LimitValues) -> Result<(), BuildError> {
        self.cycle.lower_limits(values)
    }

    /// One tick. `healthy` is the board's own verdict on its outputs and memory; it decides the self-test.
    pub fn step(&mut self, renderer: &mut impl Renderer, sensed: Sensed, command: Command, healthy: bool) -> Telemetry {
        self.edge.put(sensed);
        let command = self.asked(command, healthy);
        self.cycle.run(&mut self.edge, renderer, command)
    }

    /// Whether a tick may feed the watchdog: the actuators are off, or the mode allows a force and it is within the limit. Checked apart from the
    /// code that made the force.
    #[must_use]
    pub fn sound(&self, record: &Telemetry) -> bool {
        match self.edge.drive() {
            Drive::Off => true,
            Drive::Force(force_n) => {
                let most_n = self.limits().max_force_n * 1.000_01; // the limiter rounds
                record.mode.allows_force() && record.fault.is_none() && force_n.dot(&force_n) <= most_n * most_n
            }
        }
    }

    /// What a board asks by itself goes before what the host asks.
    fn asked(&self, command: Command, healthy: bool) -> Command {
        let (asked, found) = match self.mode() {
            Mode::Boot => (Some(Ask::Booted), command.found),
            Mode::SelfTest if healthy => (Some(Ask::TestPassed), command.found),
            Mode::SelfTest => (None, command.found.or(Some(Fault::SelfTestFailed))),
            Mode::Idle if self.arming == Arming::ByItself => (command.asked.or(Some(Ask::Arm)), command.found),
            Mode::Idle if self.arming == Arming::Barred => (command.asked.filter(|asked| *asked != Ask::Arm), command.found),
            _ => (command.asked, command.found),
        };
        Command { asked, found, ..command }
    }
}

#[cfg(test)]
mod tests {
    use palpate::haptic::device::SensorStatus;
    use palpate::{Output, ProbePose, Vector3};

    use super::*;

    /// Tissue that is never touched.
    struct Air;

    impl Renderer for Air {
        fn render(&mut self, _: ProbePose) -> Output {
            Output::NONE
        }

        fn reset(&mut self) {}
    }

    fn modes(arming: Arming, healthy: bool, ask: Option<Ask>) -> (Mode, Option<Fault>) {
        let mut controller = Controller::build(&Settings::safe(&Edge::DESKTOP.limits()), Edge::DESKTOP, arming).unwrap();
        let mut fault = None;
        for sequence in 0..300 {
            let sensed = Sensed { position_m: Vector3::zeros(), sequence, status: SensorStatus::Good };
            fault = controller.step(&mut Air, sensed, Command { asked: ask, ..Command::HEARD }, healthy).fault;
        }
        (controller.mode(), fault)
    }

    #[test]
    fn it_starts_up_by_itself_and_arms_when_it_may() {
        assert_eq!(modes(Arming::OnRequest, true, None), (Mode::Idle, None));
        assert_eq!(modes(Arming::OnRequest, true, Some(Ask::Arm)), (Mode::Active, None));
        assert_eq!(modes(Arming::ByItself, true, None), (Mode::Active, None));
    }

    #[test]
    fn a_barred_board_stays_idle_whatever_the_host_asks() {
        assert_eq!(modes(Arming::Barred, true, Some(Ask::Arm)), (Mode::Idle, None));
    }

    #[test]
    fn an_unhealthy_board_faults() {
        assert_eq!(modes(Arming::ByItself, false, Some(Ask::Arm)), (Mode::Fault, Some(Fault::SelfTestFailed)));
    }
}
