//! Paddle, pantograph and the template for new devices on the emulated board: the profile is sent
//! over the link, the home pose is declared, counts go in and force codes come out. Every record
//! equals that of the desktop's controller to the bit. By an independent Jacobian, the codes give
//! the motors the power that the hand receives.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use palpate::haptic::cycle::Settings;
use palpate::haptic::device::{HapticDevice, Sensed, SensorStatus};
use palpate::haptic::mode::Mode;
use palpate_board::desktop_board::DesktopBoard;
use palpate_board::{Board, EmulatedBoard};
use palpate_controller::config::Profile;
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::haptic_loop::HapticLoop;
use palpate_controller::kinematics::{MechanismError, MechanismProfile};
use palpate_controller::link::inbox::{Inbox, Reply};
use palpate_controller::link::message::HostAsk;
use palpate_controller::link::{FromBoard, Record, Refusal, ToBoard};
use palpate_controller::patch::{Memory, Patch};
use palpate_controller::port::Port;
use palpate_controller::probe_in::Reading;
use palpate_controller::script;
use palpate_sim::port::device_file;
use palpate_tests::emulator::build_firmware;
use palpate_tests::flash_patch::in_flash;
use palpate_tests::joint_hand::{counts_at, jacobian_m, joints_rad};
use palpate_tests::palpate_command::repository;

/// Encoder counts at power-on. They may have any value within the workspace that the board assumes
/// for its axes.
const POWER_ON_COUNTS: [i32; 3] = [2_345, -777, 31];
/// Ticks of the script's tap, hold, retreat and slide, after its wait.
const TICKS: u32 = script::LEAD_TICKS + 2_000;
/// Ticks from the home pose to the script's first position.
const APPROACH_TICKS: u32 = 400;

fn image() -> PathBuf {
    build_firmware(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), &[]).unwrap()
}

fn shipped(name: &str) -> Profile {
    let file = repository().join(format!("firmware/controller/devices/{name}.toml"));
    device_file::load(file.to_str().unwrap()).unwrap_or_else(|error| panic!("{error}")).1
}

/// The emulated board, and the desktop's controller that receives the same messages.
struct Both<'a> {
    board: Board,
    haptic: HapticLoop<DesktopBoard>,
    patch: Patch<'a>,
    inbox: Inbox,
    newest: Reading,
    sequence: u32,
}

impl<'a> Both<'a> {
    fn start(memory: &'a mut Memory) -> Self {
        let settings = Settings::safe(&Port::DESKTOP.limits());
        let controller = Controller::build(&settings, Port::DESKTOP, Arming::OnRequest).unwrap();
        let failed = Sensed { position_m: Vector3::zeros(), sequence: 0, status: SensorStatus::Failed };
        Self {
            board: Board::start(&image(), EmulatedBoard::M4f, None).unwrap(),
            haptic: HapticLoop::new(DesktopBoard::default(), controller),
            patch: Patch::open(in_flash(), memory, None).unwrap(),
            inbox: Inbox::default(),
            newest: Reading::Tip(failed),
            sequence: 0,
        }
    }

    fn tick(&mut self, counts: [i32; 3], good: bool) -> Record {
        self.sequence += 1;
        let message = ToBoard::Joints { counts, sequence: self.sequence, good };
        self.board.send(&message).unwrap();
        assert_eq!(self.inbox.take(&message, &mut self.haptic.controller, None), Reply::Tick);
        let (reading, command) = self.inbox.clear();
        self.newest = reading.unwrap();
        let here = self.haptic.tick(&mut self.patch, self.newest, command, None);
        self.patch.settle(self.haptic.controller.in_contact());
        let FromBoard::Record(there) = self.board.receive().unwrap() else { panic!("no record") };
        assert_eq!(there.first_difference(&here), None, "tick {}", here.tick);
        there
    }

    /// Sends a message that the board answers at once; returns that answer and the reply of the
    /// desktop's inbox.
    fn ask(&mut self, message: &ToBoard<'_>) -> (FromBoard, Reply) {
        self.board.send(message).unwrap();
        (self.board.receive().unwrap(), self.inbox.take(message, &mut self.haptic.controller, None))
    }

    fn store(&mut self, profile: Profile) {
        assert_eq!(self.ask(&ToBoard::Store(profile)), (FromBoard::Stored(1), Reply::Store));
        let (settings, port) = profile.split();
        self.haptic.controller.restart(&settings, port).unwrap();
    }

    fn home(&mut self) {
        assert_eq!(self.ask(&ToBoard::Home), (FromBoard::Homed, Reply::Home));
        assert!(self.haptic.controller.show_home(&self.newest));
    }

    fn arm(&mut self) {
        let message = ToBoard::Ask(HostAsk::Arm);
        self.board.send(&message).unwrap();
        assert_eq!(self.inbox.take(&message, &mut self.haptic.controller, None), Reply::None);
    }
}

/// Checks the codes against the transposed Jacobian of an independent description of the mechanism,
/// within one code plus a thousandth of the code.
fn codes_are_right(mechanism: &MechanismProfile, from_home: [i32; 3], record: &Record) {
    let jacobian = jacobian_m(mechanism, joints_rad(mechanism, from_home));
    let torque_n_m = jacobian.transpose() * Vector3::from(record.applied_n).cast::<f64>();
    for joint in 0..3 {
        let full = f64::from(mechanism.full_scale_n_m[joint]);
        let code = if full == 0.0 { 0.0 } else { torque_n_m[joint] / full * 32_767.0 };
        let (there, slack) = (f64::from(record.codes[joint]), 1.0 + 1e-3 * code.abs());
        assert!((there - code).abs() <= slack, "tick {}, joint {joint}: {there} for {code}", record.tick);
    }
}

fn pressed_through(name: &str, least_n: f32) {
    let profile = shipped(name);
    let mechanism = profile.mechanism.unwrap();
    let mut memory = Box::new(Memory::RESERVED);
    let mut both = Both::start(&mut memory);
    for _ in 0..3 {
        both.tick(POWER_ON_COUNTS, true);
    }
    both.store(profile);
    for _ in 0..3 {
        both.tick(POWER_ON_COUNTS, true);
    }
    assert_eq!(both.haptic.controller.mode(), Mode::Idle);
    let refused = FromBoard::Refused(Refusal::NotHomed);
    assert_eq!(both.ask(&ToBoard::Ask(HostAsk::Arm)), (refused, Reply::Refused(Refusal::NotHomed)));
    both.home();

    let place = |tick: u32| Vector3::from(script::counts(tick, script::LEAD_TICKS).map(|axis| f64::from(axis.0) * 1e-5));
    let counted = |from_home: [i32; 3]| std::array::from_fn(|joint| POWER_ON_COUNTS[joint] + from_home[joint]);
    let first = counts_at(&mechanism, place(0));
    for n in 0..APPROACH_TICKS {
        // the path is linear in joint space
        let share = |joint: i32| (i64::from(joint) * i64::from(n) / i64::from(APPROACH_TICKS)) as i32;
        both.tick(counted(first.map(share)), true);
    }
    both.arm();
    let (mut largest_n, mut motors_j, mut hand_j, mut exchanged_j) = (0.0_f32, 0.0, 0.0, 0.0);
    let mut last = None::<([i32; 3], Record)>;
    for tick in 0..TICKS {
        let from_home = counts_at(&mechanism, place(tick));
        let record = both.tick(counted(from_home), true);
        assert_eq!(record.fault(), None, "tick {tick}");
        largest_n = largest_n.max(record.applied_n[2]);
        codes_are_right(&mechanism, from_home, &record);
        if let Some((counts, before)) = last.replace((from_home, record)) {
            let motors = (0..3).map(|joint| {
                let torque = f64::from(before.codes[joint]) / 32_767.0 * f64::from(mechanism.full_scale_n_m[joint]);
                torque * f64::from(from_home[joint] - counts[joint]) * f64::from(mechanism.rad_per_count[joint])
            });
            let moved = Vector3::from(record.position_m).cast::<f64>() - Vector3::from(before.position_m).cast();
            let hand = Vector3::from(before.applied_n).cast::<f64>().dot(&moved);
            motors_j += motors.sum::<f64>();
            hand_j += hand;
            exchanged_j += hand.abs();
        }
    }
    println!(
        "{name}: {largest_n:.3} N at most; motors {:.2} uJ, hand {:.2} uJ of {:.2} uJ",
        motors_j * 1e6,
        hand_j * 1e6,
        exchanged_j * 1e6
    );
    assert_eq!(both.haptic.controller.mode(), Mode::Active);
    assert!(largest_n > least_n, "the press of 4 mm was not felt: {largest_n} N");
    // in one tick of the tap the joints move by about a hundredth of a radian
    assert!((motors_j - hand_j).abs() < 0.01 * exchanged_j, "motors {motors_j} J, hand {hand_j} J of {exchanged_j} J");
    // an encoder failure ends the force and clears the home pose
    let record = both.tick(POWER_ON_COUNTS, false);
    assert!(!record.enabled && record.fault == 5, "{record:?}");
    assert!(!both.haptic.controller.homed());
}

#[test]
fn a_paddle_presses_and_keeps_power() {
    pressed_through("paddle", 0.1);
}

#[test]
fn a_pantograph_presses_and_keeps_power() {
    pressed_through("pantograph", 0.1);
}

#[test]
fn the_template_presses_and_keeps_power() {
    pressed_through("your-device", 0.1);
}

#[test]
fn what_cannot_move_so_is_refused_and_arms_that_do_not_close_are_a_failed_sensor() {
    let mut memory = Box::new(Memory::RESERVED);
    let mut both = Both::start(&mut memory);
    for _ in 0..3 {
        both.tick([0; 3], true);
    }
    let profile = shipped("pantograph");
    type Spoil = fn(&mut Profile, &mut MechanismProfile);
    let spoilt = |spoil: Spoil| {
        let (mut bad, mut mechanism) = (profile, profile.mechanism.unwrap());
        spoil(&mut bad, &mut mechanism);
        bad.mechanism = Some(mechanism);
        bad
    };
    let cases: [(Spoil, MechanismError); 7] = [
        (|_, it| it.rad_per_count[1] = 0.0, MechanismError::Encoder),
        (|_, it| it.full_scale_n_m[0] = f32::NAN, MechanismError::Motor),
        (|_, it| it.dimensions[1] = -0.075, MechanismError::Arms),
        (|_, it| it.home_rad = [0.0, core::f32::consts::PI, 0.0], MechanismError::Home),
        (|bad, _| bad.workspace_m[1][2] = 0.05, MechanismError::Reach),
        (|_, it| it.full_scale_n_m = [0.01, 0.01, 0.0], MechanismError::Force),
        (|bad, _| bad.count_m *= 10.0, MechanismError::Count),
    ];
    for (spoil, why) in cases {
        assert_eq!(both.ask(&ToBoard::Store(spoilt(spoil))).0, FromBoard::Refused(Refusal::Mechanism(why)));
    }
    both.store(profile);
    for _ in 0..3 {
        both.tick([0; 3], true);
    }
    both.home();
    both.tick([0; 3], true);
    // both arms are turned outwards by 60 degrees, so the distal links do not meet
    let record = both.tick([-5_461, -5_461, 0], true);
    assert_eq!((record.mode(), record.fault, record.enabled), (Some(Mode::Fault), 5, false));
    assert_eq!(both.ask(&ToBoard::Home).0, FromBoard::Refused(Refusal::NotIdle));
}
