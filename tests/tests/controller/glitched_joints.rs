//! A joint reading that is rejected as a glitch does not change the torque: force and Jacobian are
//! those of the previous pose. After a sensor fault the device has to be homed again.

use palpate::haptic::cycle::{Ask, Command};
use palpate::haptic::device::SensorStatus;
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Fault};
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::patch::{Memory, Patch};
use palpate_controller::probe_in::{EncoderCounts, JointReading, Reading};
use palpate_sim::port::device_file;
use palpate_tests::flash_patch::in_flash;
use palpate_tests::palpate_command::repository;

/// Ticks in the home pose, on the way to 3 mm above the tissue, waiting there until armed, pressing
/// to 2 mm depth, and holding.
const STILL: u32 = 10;
const APPROACH: u32 = 500;
const ARMED: u32 = 1_500;
const PRESS: u32 = 500;
const HELD: u32 = 200;
/// Jump of the joint [rad], which reduces the paddle's lever arm to less than half.
const JUMP_RAD: f64 = 1.2;

#[test]
fn one_jump_of_a_joint_under_force_leaves_the_torque_and_a_dead_encoder_the_home_pose() {
    let file = repository().join("firmware/controller/devices/paddle.toml");
    let profile = device_file::load(file.to_str().unwrap()).unwrap().1;
    let mechanism = profile.mechanism.unwrap();
    assert!(mechanism.homing, "the paddle that ships is homed");
    let (arm_m, home) = (f64::from(mechanism.dimensions[0]), f64::from(mechanism.home_rad[0]));
    let (settings, port) = profile.split();
    let mut controller = Controller::build(&settings, port, Arming::OnRequest).unwrap();
    let mut memory = Box::new(Memory::RESERVED);
    let mut patch = Patch::open(in_flash(), &mut memory, None).unwrap();
    let home_m = arm_m * home.sin();
    let counts = |q: f64| ((q - home) / f64::from(mechanism.rad_per_count[0])).round() as i32;
    let mut sequence = 0;
    let mut tick = |controller: &mut Controller, q: f64, status, asked| {
        sequence += 1;
        let reading = Reading::Joints(JointReading { counts: [counts(q), 0, 0].map(EncoderCounts), sequence, status });
        let record = controller.tick(&mut patch, reading, Command { asked, ..Command::HEARD }, true);
        patch.settle(controller.in_contact());
        (record, reading)
    };
    let mut q = home;
    for n in 0..STILL + APPROACH + ARMED + PRESS + HELD {
        let share = |from: u32, ticks: u32| f64::from(n.saturating_sub(from).min(ticks)) / f64::from(ticks);
        let down_m = (home_m - 3e-3) * share(STILL, APPROACH) + 5e-3 * share(STILL + APPROACH + ARMED, PRESS);
        q = ((home_m - down_m) / arm_m).asin();
        let asked = (controller.mode() == Mode::Idle && n == STILL + APPROACH).then_some(Ask::Arm);
        let (record, reading) = tick(&mut controller, q, SensorStatus::Good, asked);
        assert_eq!(record.fault, None, "tick {n}");
        if n == STILL - 1 {
            assert!(controller.show_home(&reading));
        }
    }
    let before = controller.outputs();
    assert!(before.enabled && before.codes[0].0.abs() > 100, "{before:?}");

    let (record, _) = tick(&mut controller, q + JUMP_RAD, SensorStatus::Good, None);
    assert!(record.limiters.contains(ClampFlags::HELD) && record.fault.is_none(), "{record:?}");
    let off = f64::from(controller.outputs().codes[0].0) / f64::from(before.codes[0].0) - 1.0;
    assert!(off.abs() < 0.05, "the torque of a joint that is not believed: {off}");

    let mut fault = None;
    for _ in 0..200 {
        fault = fault.or(tick(&mut controller, q, SensorStatus::Failed, None).0.fault);
    }
    assert_eq!(fault, Some(Fault::SensorFault));
    tick(&mut controller, q, SensorStatus::Good, Some(Ask::Clear));
    for _ in 0..50 {
        tick(&mut controller, q, SensorStatus::Good, Some(Ask::Arm));
    }
    assert!(matches!(controller.mode(), Mode::Idle | Mode::Fault), "armed without a home pose: {:?}", controller.mode());
}
