//! The inbox of the controller. Messages for the haptic cycle are stored until the next tick;
//! messages that concern the patch or the board are returned to the caller.

use palpate::Fault;
use palpate::haptic::cycle::{Ask, Command};
use palpate::haptic::device::{Sensed, SensorStatus};
use palpate::haptic::mode::{Mode, Request};

use super::message::{HostAsk, ToBoard};
use super::upload::Upload;
use crate::commission::Setup;
use crate::config::Profile;
use crate::controller::Controller;
use crate::probe_in::{EncoderCounts, JointReading, Reading};
use crate::refusal::Refusal;

/// A change that only the owner of the patch can make, between two ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Discard the patch: another one of this many bytes will follow.
    MakeRoom(u32),
    /// Open the patch that was received.
    Take,
    /// Reopen the same patch with another Young's modulus [Pa].
    Modulus(f32),
}

/// Immediate consequence of a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reply {
    /// Nothing to do before the next tick.
    None,
    /// The tick's input is complete.
    Tick,
    /// Send the host this refusal.
    Refused(Refusal),
    /// The owner of the patch has to make this change.
    Change(Change),
    /// Request another Young's modulus [Pa] for the running patch; [`crate::patch::Patch::settle`]
    /// applies it.
    Modulus(f32),
    /// Send the host the state.
    Report,
    /// Send the host the board's identity.
    Identify,
    /// Store the profile that came last ([`Inbox::profile`]) and restart with it.
    Store,
    /// Use the present pose as the home pose.
    Home,
    /// Whether the host reads the log from now on.
    Listen(bool),
    /// Begin a commissioning.
    Commission(Setup),
    /// The user confirms a step of the commissioning.
    Confirm,
}

/// Content of the messages since the last tick, and the profile that came last.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inbox {
    new: New,
    profile: Option<Profile>,
}

/// Content of the messages since the last tick.
#[derive(Clone, Copy, Debug, Default)]
struct New {
    heard: bool,
    asked: Option<Ask>,
    reading: Option<Reading>,
    found: Option<Fault>,
    operator_present: bool,
}

impl Inbox {
    /// Processes a message. `upload` is the memory for a patch, or `None` while a patch is open.
    pub fn take(&mut self, message: &ToBoard<'_>, controller: &mut Controller, upload: Option<&mut Upload>) -> Reply {
        let new = &mut self.new;
        new.heard = true;
        match *message {
            ToBoard::Heartbeat => Reply::None,
            ToBoard::Pose { position_m, sequence, good } => {
                let status = if good { SensorStatus::Good } else { SensorStatus::Failed };
                new.reading = Some(Reading::Tip(Sensed { position_m: position_m.into(), sequence, status }));
                Reply::Tick
            }
            ToBoard::Joints { counts, sequence, good } => {
                let status = if good { SensorStatus::Good } else { SensorStatus::Failed };
                new.reading = Some(Reading::Joints(JointReading { counts: counts.map(EncoderCounts), sequence, status }));
                Reply::Tick
            }
            ToBoard::Ask(HostAsk::Arm) if controller.barred() => Reply::Refused(Refusal::Barred),
            ToBoard::Ask(HostAsk::Arm) if upload.is_some() => Reply::Refused(Refusal::NoPatch),
            ToBoard::Ask(HostAsk::Arm) if !controller.homed() => Reply::Refused(Refusal::NotHomed),
            // a stop overrides every request that arrives after it before the next tick
            ToBoard::Ask(asked) => {
                if new.asked != Some(Ask::Stop) {
                    new.asked = Some(asked.into());
                }
                Reply::None
            }
            ToBoard::LowerLimits(bounds) => match controller.lower_limits(&(&bounds).into()) {
                Ok(()) => Reply::None,
                Err(_) => Reply::Refused(Refusal::LimitRises),
            },
            ToBoard::YoungsModulus(pascal) => match controller.mode() {
                Mode::Idle => Reply::Change(Change::Modulus(pascal)),
                mode if mode.accepts(Request::Parameter) => Reply::Modulus(pascal),
                _ => Reply::Refused(Refusal::NotIdle),
            },
            ToBoard::PatchBegin(bytes) => idle(controller.mode(), Change::MakeRoom(bytes)),
            ToBoard::PatchPart { at, bytes } => match upload.map_or(Err(Refusal::PatchPieces), |memory| memory.part(at, bytes)) {
                Ok(()) => Reply::None,
                Err(refusal) => Reply::Refused(refusal),
            },
            ToBoard::PatchEnd => match upload {
                Some(_) => idle(controller.mode(), Change::Take),
                None => Reply::Refused(Refusal::PatchPieces),
            },
            ToBoard::SupplyLow => {
                new.found = Some(Fault::SupplyLow);
                Reply::None
            }
            ToBoard::EmergencyStop => {
                new.found = Some(Fault::EmergencyStop);
                Reply::None
            }
            ToBoard::Operator(present) => {
                new.operator_present = present;
                Reply::None
            }
            ToBoard::Report => Reply::Report,
            ToBoard::Identify => Reply::Identify,
            ToBoard::Listen(listens) => Reply::Listen(listens),
            ToBoard::Store(profile) if controller.mode().accepts(Request::Config) => {
                self.profile = Some(profile);
                Reply::Store
            }
            ToBoard::Home if controller.mode().accepts(Request::Config) => Reply::Home,
            ToBoard::Commission(setup) if !setup.sound() => Reply::Refused(Refusal::Commissioning),
            ToBoard::Commission(_) if controller.barred() => Reply::Refused(Refusal::Barred),
            ToBoard::Commission(setup) if controller.mode().accepts(Request::Config) => Reply::Commission(setup),
            ToBoard::Confirm => Reply::Confirm,
            ToBoard::Store(_) | ToBoard::Home | ToBoard::Commission(_) => Reply::Refused(Refusal::NotIdle),
        }
    }

    /// The profile that came last. It is not part of a [`Reply`], which would be as large as a
    /// profile in every copy.
    #[must_use]
    pub fn profile(&self) -> Option<&Profile> {
        self.profile.as_ref()
    }

    /// Empties the inbox: returns the host's newest reading and the command for the next tick. A
    /// reading is returned only once, so that the cycle can tell the age of the last one.
    pub fn clear(&mut self) -> (Option<Reading>, Command) {
        let New { heard, asked, reading, found, operator_present } = core::mem::take(&mut self.new);
        self.new.operator_present = operator_present;
        (reading, Command { heard, asked, found, operator_absent: !operator_present, ..Command::default() })
    }
}

fn idle(mode: Mode, change: Change) -> Reply {
    if mode.accepts(Request::Mesh) { Reply::Change(change) } else { Reply::Refused(Refusal::NotIdle) }
}

#[cfg(test)]
mod tests {
    use palpate::haptic::cycle::{Renderer, Settings};
    use palpate::haptic::device::HapticDevice;
    use palpate::{Output, ProbePose, Vector3};

    use super::*;
    use crate::controller::Arming;
    use crate::port::Port;

    fn heard(messages: &[ToBoard<'_>]) -> Command {
        let settings = Settings::safe(&Port::DESKTOP.limits());
        let mut controller = Controller::build(&settings, Port::DESKTOP, Arming::OnRequest).unwrap();
        let mut inbox = Inbox::default();
        messages.iter().for_each(|message| assert_eq!(inbox.take(message, &mut controller, None), Reply::None));
        inbox.clear().1
    }

    #[test]
    fn nothing_that_comes_behind_a_stop_takes_it_back() {
        for behind in [HostAsk::Arm, HostAsk::Clear, HostAsk::Stop] {
            for before in [HostAsk::Arm, HostAsk::Clear] {
                let asked = heard(&[before, HostAsk::Stop, behind].map(ToBoard::Ask)).asked;
                assert_eq!(asked, Some(Ask::Stop), "{before:?}, stop, {behind:?}");
            }
        }
        assert_eq!(heard(&[HostAsk::Clear, HostAsk::Arm].map(ToBoard::Ask)).asked, Some(Ask::Arm), "else the last one counts");
    }

    #[test]
    fn a_host_tells_of_a_stop_circuit_and_of_an_operator_that_the_board_cannot_see() {
        assert_eq!(heard(&[ToBoard::EmergencyStop, ToBoard::Heartbeat]).found, Some(Fault::EmergencyStop));
        assert!(heard(&[ToBoard::Heartbeat]).operator_absent, "absent until somebody is there");
        assert!(!heard(&[ToBoard::Operator(true), ToBoard::Heartbeat]).operator_absent);
        assert!(heard(&[ToBoard::Operator(true), ToBoard::Operator(false)]).operator_absent);
    }

    #[test]
    fn a_host_was_heard_in_the_tick_in_which_a_message_came_and_in_no_other() {
        let settings = Settings::safe(&Port::DESKTOP.limits());
        let mut controller = Controller::build(&settings, Port::DESKTOP, Arming::OnRequest).unwrap();
        let mut inbox = Inbox::default();
        assert!(!inbox.clear().1.heard);
        assert_eq!(inbox.take(&ToBoard::Heartbeat, &mut controller, None), Reply::None);
        assert!(inbox.clear().1.heard);
        assert!(!inbox.clear().1.heard);
    }

    #[test]
    fn a_commissioning_begins_in_idle_alone() {
        let settings = Settings::safe(&Port::DESKTOP.limits());
        let mut controller = Controller::build(&settings, Port::DESKTOP, Arming::OnRequest).unwrap();
        let asked = ToBoard::Commission(Setup::of(&Port::DESKTOP, 3.0, 0.05));
        assert_eq!(controller.mode(), Mode::Boot);
        assert_eq!(Inbox::default().take(&asked, &mut controller, None), Reply::Refused(Refusal::NotIdle));
    }

    /// A renderer without tissue.
    struct Air;

    impl Renderer for Air {
        fn render(&mut self, _: ProbePose) -> Output {
            Output::NONE
        }

        fn reset(&mut self) {}
    }

    /// A controller in `Idle`, or armed in free space.
    fn started(arm: bool) -> Controller {
        let settings = Settings::safe(&Port::DESKTOP.limits());
        let mut controller = Controller::build(&settings, Port::DESKTOP, Arming::OnRequest).unwrap();
        for sequence in 1..2_000 {
            let good = Sensed { position_m: Vector3::zeros(), sequence, status: SensorStatus::Good };
            let asked = (arm && controller.mode() == Mode::Idle).then_some(Ask::Arm);
            controller.tick(&mut Air, good, Command { asked, ..Command::HEARD }, true);
        }
        controller
    }

    #[test]
    fn a_profile_is_kept_in_idle_alone() {
        let store = ToBoard::Store(Profile::desktop());
        let mut inbox = Inbox::default();
        assert_eq!(started(false).mode(), Mode::Idle);
        assert_eq!(inbox.take(&store, &mut started(true), None), Reply::Refused(Refusal::NotIdle));
        assert_eq!(inbox.profile(), None);
        assert_eq!(inbox.take(&store, &mut started(false), None), Reply::Store);
        assert_eq!(inbox.profile(), Some(&Profile::desktop()));
    }

    #[test]
    fn a_modulus_restarts_an_idle_patch_and_is_for_the_hand_in_an_armed_one() {
        let modulus = ToBoard::YoungsModulus(2e3);
        let mut inbox = Inbox::default();
        assert_eq!(inbox.take(&modulus, &mut started(false), None), Reply::Change(Change::Modulus(2e3)));
        let mut armed = started(true);
        assert!(armed.mode().accepts(Request::Parameter) && armed.mode() != Mode::Idle, "{:?}", armed.mode());
        assert_eq!(inbox.take(&modulus, &mut armed, None), Reply::Modulus(2e3));
        let settings = Settings::safe(&Port::DESKTOP.limits());
        let mut boot = Controller::build(&settings, Port::DESKTOP, Arming::OnRequest).unwrap();
        assert_eq!(inbox.take(&modulus, &mut boot, None), Reply::Refused(Refusal::NotIdle));
    }

    #[test]
    fn a_board_that_crashed_too_often_says_that_it_does_not_arm() {
        let settings = Settings::safe(&Port::DESKTOP.limits());
        let mut inbox = Inbox::default();
        // also without a home pose: the power cycle that ends the bar would lose it again
        for edge in [Port::DESKTOP, Port::DESKTOP.without_home()] {
            let mut barred = Controller::build(&settings, edge, Arming::Barred).unwrap();
            assert_eq!(inbox.take(&ToBoard::Ask(HostAsk::Arm), &mut barred, None), Reply::Refused(Refusal::Barred));
            assert_eq!(inbox.take(&ToBoard::Ask(HostAsk::Stop), &mut barred, None), Reply::None);
            assert_eq!(inbox.clear().1.asked, Some(Ask::Stop), "a stop is taken in every state");
        }
    }

    #[test]
    fn while_a_patch_is_on_its_way_nobody_arms() {
        let mut upload = std::boxed::Box::new(Upload::RESERVED);
        let mut inbox = Inbox::default();
        let arm = ToBoard::Ask(HostAsk::Arm);
        assert_eq!(inbox.take(&arm, &mut started(false), Some(&mut upload)), Reply::Refused(Refusal::NoPatch));
        assert_eq!(inbox.clear().1.asked, None);
        assert_eq!(inbox.take(&arm, &mut started(false), None), Reply::None);
        assert_eq!(inbox.clear().1.asked, Some(Ask::Arm));
    }
}
