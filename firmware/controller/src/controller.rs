//! One tick of the controller without its board: the haptic cycle, its device and the requests that
//! the board itself makes.
//!
//! * in: a reading, and the host's requests and the board's findings since the last tick
//! * out: a command to the actuators, a telemetry record
//! * cost: that of [`palpate::haptic::cycle`]
//! * failures: every [`palpate::Fault`]; the actuators are off then

use palpate::haptic::account::{AccountSettings, EnergyAccount, EnergyBound};
use palpate::haptic::cycle::{Ask, Command, Cycle, Renderer, Settings, Telemetry};
use palpate::haptic::device::{DeviceSpec, HapticDevice};
use palpate::haptic::limits::LoopLimitSettings;
use palpate::haptic::mode::Mode;
use palpate::{BuildError, ClampFlags, Fault};

use crate::force_out::{ActuatorCommand, Outputs};
use crate::patch::TICK_S;
use crate::port::Port;
use crate::probe_in::Reading;

/// Ways in which the board may be armed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arming {
    /// Only at the host's request.
    OnRequest,
    /// Without a request once after power-on, for images that serve no host. After a stop, a lost
    /// host or a fault, only at a new request: from the host, or by releasing and pressing the
    /// operator's switch. On a device with such a switch, power-on does not count as a request,
    /// since a jammed switch would then arm the board.
    ByItself,
    /// Not before a power cycle or a press of the reset button, because the board crashed, or its
    /// watchdog reset it, too often.
    Barred,
}

/// The haptic cycle with its device, and the rules by which the board is armed.
#[derive(Clone, Copy, Debug)]
pub struct Controller {
    cycle: Cycle,
    edge: Port,
    arming: Arming,
    /// Whether there is a request to arm, by power-on or the operator's switch, that has not been
    /// used yet.
    fresh: bool,
    /// Whether the operator's switch was released in the last tick.
    was_absent: bool,
}

impl Controller {
    /// Creates a controller in `Boot`.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the setting.
    pub fn build(settings: &Settings, edge: Port, arming: Arming) -> Result<Self, BuildError> {
        let fresh = !edge.operator_switch();
        Ok(Self { cycle: Cycle::build(settings, &edge.limits())?, edge, arming, fresh, was_absent: false })
    }

    /// Mode of the haptic cycle.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.cycle.mode()
    }

    /// Restarts with other settings and another device; there is no force until the board is armed
    /// again.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the setting; nothing changes then.
    pub fn restart(&mut self, settings: &Settings, edge: Port) -> Result<(), BuildError> {
        // a new profile does not count as a request to arm
        *self = Self { fresh: false, ..Self::build(settings, edge, self.arming)? };
        Ok(())
    }

    /// Whether the last pose touched the patch.
    #[must_use]
    pub fn in_contact(&self) -> bool {
        self.cycle.in_contact()
    }

    /// Largest contact stiffness that the device renders [N/m].
    #[must_use]
    pub fn stiffness_ceiling_n_per_m(&self) -> f32 {
        self.edge.limits().ceiling_n_per_m(TICK_S)
    }

    /// Limits of the loop that apply now.
    #[must_use]
    pub fn limits(&self) -> &LoopLimitSettings {
        self.cycle.limits()
    }

    /// The most energy that the device can give the hand. No profile changes the account.
    #[must_use]
    pub fn energy_bound(&self) -> EnergyBound {
        EnergyAccount::bound(&AccountSettings::DEFAULT, &self.edge.limits(), TICK_S, 0)
    }

    /// Command to the actuators after the last tick.
    #[must_use]
    pub fn drive(&self) -> ActuatorCommand {
        self.edge.drive()
    }

    /// State that the board's outputs should have after the last tick.
    #[must_use]
    pub fn outputs(&self) -> Outputs {
        self.edge.outputs()
    }

    /// Whether arming is barred: see [`Arming::Barred`].
    #[must_use]
    pub fn barred(&self) -> bool {
        self.arming == Arming::Barred
    }

    /// Whether the device's home pose is known; the board does not arm before that.
    #[must_use]
    pub fn homed(&self) -> bool {
        self.edge.homed()
    }

    /// Records the present joint positions as the home pose; called in `Idle`. Returns false if
    /// `reading` has no valid encoder counts.
    pub fn show_home(&mut self, reading: &Reading) -> bool {
        let shown = self.edge.show_home(reading);
        if shown && !self.edge.known() {
            // encoders of their own without a profile: nobody has measured their axes
            let max_force_n = self.limits().max_force_n.min(DeviceSpec::UNCOMMISSIONED_N);
            let lowered = self.lower_limits(&LoopLimitSettings { max_force_n, ..*self.limits() });
            debug_assert!(lowered.is_ok(), "a smaller force is in range");
        }
        shown
    }

    /// Whether the device has a hand switch or a pedal.
    #[must_use]
    pub fn operator_switch(&self) -> bool {
        self.edge.operator_switch()
    }

    /// Whether the device was commissioned.
    #[must_use]
    pub fn commissioned(&self) -> bool {
        self.edge.known() && self.edge.limits().commissioned
    }

    /// Lowers limits; allowed in any mode.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] names the limit that would rise; nothing changes then.
    pub fn lower_limits(&mut self, values: &LoopLimitSettings) -> Result<(), BuildError> {
        self.cycle.lower_limits(values)
    }

    /// Runs one tick. `healthy` is the board's own check of its outputs and memory; it decides the
    /// self-test.
    pub fn tick(
        &mut self,
        renderer: &mut impl Renderer,
        reading: impl Into<Reading>,
        command: Command,
        healthy: bool,
    ) -> Telemetry {
        let believed = self.edge.device().linkage();
        self.edge.put(&reading.into());
        let command = self.present(command);
        let command = self.asked(command, healthy);
        let telemetry = self.cycle.tick(&mut self.edge, renderer, command);
        if telemetry.limiters.contains(ClampFlags::HELD) {
            self.edge.device().go_back(believed);
        }
        if matches!(telemetry.fault, Some(Fault::SensorFault | Fault::OverSpeed | Fault::OutOfWorkspace)) {
            self.edge.device().forget_home();
        }
        // a request is used up by leaving `Idle`, whatever happens next, and by a stop
        self.fresh &= matches!(telemetry.mode, Mode::Boot | Mode::SelfTest | Mode::Idle) && command.asked != Some(Ask::Stop);
        telemetry
    }

    /// Whether a tick may feed the watchdog: the actuators are off, or the mode allows a force, no
    /// fault is present, and the force is within the limit. The check is independent of the code
    /// that computed the force.
    #[must_use]
    pub fn sound(&self, record: &Telemetry) -> bool {
        match self.edge.drive() {
            ActuatorCommand::Off => true,
            ActuatorCommand::Force(force_n) => {
                let most_n = self.limits().max_force_n * 1.000_01; // the limiter rounds
                record.mode.allows_force() && record.fault.is_none() && force_n.dot(&force_n) <= most_n * most_n
            }
        }
    }

    /// Tracks the operator's switch, if the device has one: pressing it again is a new request to
    /// arm.
    fn present(&mut self, command: Command) -> Command {
        let operator_absent = self.edge.operator_switch() && command.operator_absent;
        self.fresh |= self.was_absent && !operator_absent;
        self.was_absent = operator_absent;
        Command { operator_absent, ..command }
    }

    /// Merges the board's own requests with the host's. In `Boot` and `SelfTest` the board's
    /// request replaces the host's; in `Idle` the host's comes first, and a request to arm is
    /// dropped if arming is barred or the home pose is unknown.
    fn asked(&self, command: Command, healthy: bool) -> Command {
        let (asked, found) = match self.mode() {
            Mode::Boot => (Some(Ask::Booted), command.found),
            Mode::SelfTest if healthy => (Some(Ask::TestPassed), command.found),
            Mode::SelfTest => (None, command.found.or(Some(Fault::SelfTestFailed))),
            Mode::Idle if self.arming == Arming::ByItself && self.fresh && !command.operator_absent && self.homed() => {
                (command.asked.or(Some(Ask::Arm)), command.found)
            }
            Mode::Idle if self.arming == Arming::Barred || !self.homed() => {
                (command.asked.filter(|asked| *asked != Ask::Arm), command.found)
            }
            _ => (command.asked, command.found),
        };
        Command { asked, found, ..command }
    }
}

#[cfg(test)]
mod tests {
    use palpate::haptic::device::{Sensed, SensorStatus};
    use palpate::{Output, ProbePose, Vector3};

    use super::*;

    /// A renderer whose tissue is never touched.
    struct Air;

    impl Renderer for Air {
        fn render(&mut self, _: ProbePose) -> Output {
            Output::NONE
        }

        fn reset(&mut self) {}
    }

    fn controller(arming: Arming, edge: Port) -> Controller {
        Controller::build(&Settings::safe(&Port::DESKTOP.limits()), edge, arming).unwrap()
    }

    /// Runs `ticks` ticks with the same command in free space.
    fn ticks(controller: &mut Controller, ticks: u32, command: Command, healthy: bool) -> Telemetry {
        let mut telemetry = None;
        for _ in 0..ticks {
            let sequence = controller.edge.sense().sequence.wrapping_add(1);
            let sensed = Sensed { position_m: Vector3::zeros(), sequence, status: SensorStatus::Good };
            telemetry = Some(controller.tick(&mut Air, sensed, command, healthy));
        }
        telemetry.unwrap()
    }

    fn modes(arming: Arming, healthy: bool, ask: Option<Ask>) -> (Mode, Option<Fault>) {
        let mut controller = controller(arming, Port::DESKTOP);
        let telemetry = ticks(&mut controller, 300, Command { asked: ask, ..Command::HEARD }, healthy);
        (controller.mode(), telemetry.fault)
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

    #[test]
    fn stopped_it_arms_again_by_a_fresh_sign_only() {
        let asks = |asked| Command { asked: Some(asked), ..Command::HEARD };
        let mut board = controller(Arming::ByItself, Port::DESKTOP);
        ticks(&mut board, 300, Command::HEARD, true);
        assert_eq!(board.mode(), Mode::Active);
        ticks(&mut board, 1, asks(Ask::Stop), true);
        ticks(&mut board, 1_000, Command::HEARD, true);
        assert_eq!(board.mode(), Mode::Idle, "a stop holds");
        ticks(&mut board, 1, asks(Ask::Arm), true);
        ticks(&mut board, 300, Command::HEARD, true);
        assert_eq!(board.mode(), Mode::Active, "the host's request is a fresh sign");
        ticks(&mut board, 300, Command::default(), true);
        ticks(&mut board, 300, Command::HEARD, true);
        assert_eq!(board.mode(), Mode::Idle, "a host that was lost and came back has asked for nothing");
        let settings = Settings::safe(&Port::DESKTOP.limits());
        board.restart(&settings, Port::DESKTOP).unwrap();
        ticks(&mut board, 300, Command::HEARD, true);
        assert_eq!(board.mode(), Mode::Idle, "nor is a new profile a sign");
    }

    #[test]
    fn a_stop_in_idle_takes_back_the_request_of_power_on() {
        let asks = |asked| Command { asked: Some(asked), ..Command::HEARD };
        let mut board = controller(Arming::ByItself, Port::DESKTOP);
        let in_idle = (0..10).find(|_| {
            ticks(&mut board, 1, Command::HEARD, true);
            board.mode() == Mode::Idle
        });
        assert!(in_idle.is_some());
        ticks(&mut board, 1, asks(Ask::Stop), true);
        ticks(&mut board, 1_000, Command::HEARD, true);
        assert_eq!(board.mode(), Mode::Idle);
        ticks(&mut board, 1, asks(Ask::Arm), true);
        ticks(&mut board, 300, Command::HEARD, true);
        assert_eq!(board.mode(), Mode::Active);
    }

    #[test]
    fn an_emergency_stop_behind_another_fault_is_told_and_latches() {
        let found = |fault| Command { found: Some(fault), ..Command::HEARD };
        let mut board = controller(Arming::ByItself, Port::DESKTOP);
        ticks(&mut board, 300, Command::HEARD, true);
        ticks(&mut board, 1, found(Fault::SupplyLow), true);
        let telemetry = ticks(&mut board, 1, found(Fault::EmergencyStop), true);
        assert_eq!((telemetry.mode, telemetry.fault), (Mode::Fault, Some(Fault::EmergencyStop)));
        let telemetry = ticks(&mut board, 1, found(Fault::SupplyLow), true);
        assert_eq!(telemetry.fault, Some(Fault::EmergencyStop));
    }

    #[test]
    fn a_fault_that_was_cleared_is_no_sign_to_arm() {
        let mut board = controller(Arming::ByItself, Port::DESKTOP);
        ticks(&mut board, 300, Command::HEARD, true);
        let telemetry = ticks(&mut board, 1, Command { found: Some(Fault::EmergencyStop), ..Command::HEARD }, true);
        assert_eq!((telemetry.mode, telemetry.fault), (Mode::Fault, Some(Fault::EmergencyStop)));
        ticks(&mut board, 300, Command::HEARD, true);
        assert_eq!(board.mode(), Mode::Fault, "latched");
        ticks(&mut board, 1, Command { asked: Some(Ask::Clear), ..Command::HEARD }, true);
        ticks(&mut board, 300, Command::HEARD, true);
        assert_eq!(board.mode(), Mode::Idle);
    }

    #[test]
    fn with_an_operator_switch_it_arms_when_that_is_released_and_pressed_again() {
        let absent = Command { operator_absent: true, ..Command::HEARD };
        let mut board = controller(Arming::ByItself, Port::DESKTOP.with_operator_switch(true));
        ticks(&mut board, 300, Command::HEARD, true);
        assert_eq!(board.mode(), Mode::Idle, "a switch that was pressed all along may be jammed");
        ticks(&mut board, 300, absent, true);
        assert_eq!(board.mode(), Mode::Idle, "nobody is there");
        ticks(&mut board, 300, Command::HEARD, true);
        assert_eq!(board.mode(), Mode::Active);
        ticks(&mut board, 1, Command { asked: Some(Ask::Stop), ..Command::HEARD }, true);
        ticks(&mut board, 300, Command::HEARD, true);
        assert_eq!(board.mode(), Mode::Idle, "still pressed");
        ticks(&mut board, 1, absent, true);
        ticks(&mut board, 300, Command::HEARD, true);
        assert_eq!(board.mode(), Mode::Active, "pressed again");
    }

    #[test]
    fn the_switch_reaches_the_loop_where_the_profile_has_one_and_nowhere_else() {
        let absent = Command { operator_absent: true, ..Command::HEARD };
        assert!(controller(Arming::OnRequest, Port::DESKTOP.with_operator_switch(true)).present(absent).operator_absent);
        assert!(!controller(Arming::OnRequest, Port::DESKTOP).present(absent).operator_absent);
    }

    #[test]
    fn a_force_without_its_mode_beside_a_fault_or_beyond_the_limit_is_unsound() {
        let mut board = controller(Arming::ByItself, Port::DESKTOP);
        let telemetry = ticks(&mut board, 300, Command::HEARD, true);
        assert_eq!(telemetry.mode, Mode::Active);
        let most_n = board.limits().max_force_n;
        board.edge.actuate(Vector3::new(0.0, 0.0, most_n));
        assert!(board.sound(&telemetry));
        for (mode, fault, force_n) in [
            (Mode::Active, None, 1.001 * most_n),
            (Mode::Active, None, f32::NAN),
            (Mode::Active, Some(Fault::Diverged), 0.1),
            (Mode::Idle, None, 0.1),
            (Mode::Fault, None, 0.1),
        ] {
            board.edge.actuate(Vector3::new(0.0, 0.0, force_n));
            assert!(!board.sound(&Telemetry { mode, fault, ..telemetry }), "{mode:?} {fault:?} {force_n}");
            board.edge.release();
            assert!(board.sound(&Telemetry { mode, fault, ..telemetry }), "no force is always sound");
        }
    }
}
