//! Profile files of mechanisms: every kind has a file that is accepted, and an impossible value is
//! refused in one line that names it.

use palpate::haptic::device::{HapticDevice, Sensed, SensorStatus};
use palpate_controller::device::Device;
use palpate_controller::force_out::{ActuatorCommand, Outputs};
use palpate_controller::kinematics::Kind;
use palpate_controller::probe_in::{EncoderCounts, JointReading, Reading};
use palpate_sim::port::device_file;
use palpate_tests::palpate_command::{Desk, repository};

fn text(name: &str) -> String {
    std::fs::read_to_string(repository().join(format!("firmware/controller/devices/{name}.toml"))).unwrap()
}

fn refused(text: &str) -> String {
    let desk = Desk::default();
    desk.put("mine.toml", text);
    let path = desk.folder().join("mine.toml");
    let error = device_file::load(path.to_str().unwrap()).map(|taken| taken.1).expect_err("it is taken");
    error.to_string()
}

#[test]
fn every_kind_has_a_profile_that_a_board_takes() {
    for kind in Kind::ALL {
        let file = repository().join(format!("firmware/controller/devices/{}.toml", kind.name()));
        let (device, profile) = device_file::load(file.to_str().unwrap()).unwrap_or_else(|error| panic!("{error}"));
        let mechanism = profile.mechanism.unwrap();
        assert_eq!(mechanism.kind, *kind);
        let (count_m, said_m) = (f64::from(mechanism.count_m().unwrap()), device.count_m);
        println!("{}: one count {:.3} um, the profile says {:.3} um", kind.name(), count_m * 1e6, said_m * 1e6);
        assert!((count_m / said_m - 1.0).abs() < 0.01, "{}: {count_m} m", kind.name());
        assert!(profile.split().1.limits().check().is_ok());
    }
}

#[test]
fn what_cannot_be_is_named_in_one_line() {
    let paddle = text("paddle");
    for (from, to, says) in [
        ("kind = \"paddle\"", "kind = \"padle\"", "kind = \"padle\" is none: give one of paddle, pantograph, your-device"),
        ("arm_m = 0.09", "arm_mm = 90.0", "arm_mm is no key of a paddle: it has arm_m"),
        ("arm_m = 0.09", "", "arm_m is missing"),
        ("arm_m = 0.09", "arm_m = 90.0", "no such mechanism has these dimensions"),
        ("arm_m = 0.09", "arm_m = 0.045", "goes beyond what the mechanism reaches"),
        ("gear_ratio = [12.0]", "gear_ratio = [0.0]", "gear_ratio has 0: give a number above zero"),
        ("gear_ratio = [12.0]", "gear_ratio = [12.0, 12.0]", "gear_ratio has 2 values: a paddle has 1 joints"),
        ("counts_per_turn = [4096]", "counts_per_turn = [410]", "count_m is not what a count of every joint moves the probe by"),
        ("motor_sign = [1]", "motor_sign = [2]", "motor_sign has 2: give 1 or -1"),
        ("encoder_sign = [1]", "encoder_sing = [1]", "encoder_sing is no key of a paddle"),
        ("arm_m = 0.09", "arm_m = \"0.09\"", "arm_m is not a number"),
        ("homing = true", "homing = false\nhome_counts = [1, 2]", "home_counts has 2 values: a paddle has 1 joints"),
        ("full_scale_a = [2.0]", "full_scale_a = [0.2]", "too weak for max_force_n"),
        ("home_deg = [15.0]", "home_deg = [50.0]", "home pose"),
        ("homing = true", "", "homing"),
        ("workspace_m = [0.06, 0.06, 0.10]", "workspace_m = [0.06, 0.06, 0.30]", "goes beyond what the mechanism reaches"),
    ] {
        assert!(paddle.contains(from), "{from}");
        let said = refused(&paddle.replacen(from, to, 1));
        assert!(said.contains(says) && said.lines().count() == 1 && said.contains("mine.toml"), "{to}: {said}");
    }
    let pantograph = text("pantograph");
    for (from, to, says) in [
        ("home_deg = [60.0, 120.0]", "home_deg = [0.0, 180.0]", "cannot be in its home pose"),
        ("far_m = 0.075", "far_m = 0.040", "home pose"),
        ("centre_z_m = 0.110", "centre_z_m = 0.080", "outside workspace_m"),
    ] {
        let said = refused(&pantograph.replacen(from, to, 1));
        assert!(said.contains(says), "{to}: {said}");
    }
}

#[test]
fn a_profile_may_ask_for_an_operator_s_switch() {
    let desk = Desk::default();
    let load = |text: String| {
        desk.put("mine.toml", text);
        device_file::load(desk.folder().join("mine.toml").to_str().unwrap()).unwrap().1
    };
    assert!(!load(text("paddle")).operator_switch);
    assert!(load(text("paddle").replacen("axes = 1", "axes = 1\noperator_switch = true", 1)).operator_switch);
}

fn joints(counts: [i32; 3], sequence: u32) -> Reading {
    Reading::Joints(JointReading { counts: counts.map(EncoderCounts), sequence, status: SensorStatus::Good })
}

#[test]
fn a_force_beyond_the_converters_keeps_its_direction() {
    let file = repository().join("firmware/controller/devices/your-device.toml");
    let profile = device_file::load(file.to_str().unwrap()).unwrap().1;
    let mut device = Device::new(profile.mechanism.as_ref(), [0; 3]);
    assert!(device.show_home(&joints([5, 6, 7], 1)) && device.homed());
    assert_eq!(device.sensed(&joints([5, 6, 7], 2)).position_m, palpate::Vector3::zeros());
    let of = |force_n: [f32; 3]| device.outputs(ActuatorCommand::Force(force_n.into())).codes.map(|code| i32::from(code.0));
    let within = of([10.0, -20.0, 5.0]);
    assert_eq!(within[1], -2 * -within[0], "the x motor is turned round");
    let beyond = of([100.0, -200.0, 50.0]);
    assert_eq!(beyond[1], -32_767);
    assert!((beyond[0] + 16_384).abs() <= 1 && (beyond[2] - 8_192).abs() <= 1, "{beyond:?}");
    assert_eq!(device.outputs(ActuatorCommand::Off), Outputs::OFF);
    assert_eq!(of([f32::NAN, 1.0, 1.0]), [0; 3]);
}

#[test]
fn a_tip_without_joints_and_a_mechanism_that_was_never_checked_are_failed_sensors() {
    let file = repository().join("firmware/controller/devices/paddle.toml");
    let mechanism = device_file::load(file.to_str().unwrap()).unwrap().1.mechanism.unwrap();
    let tip = Reading::Tip(Sensed { position_m: palpate::Vector3::zeros(), sequence: 3, status: SensorStatus::Good });
    let mut device = Device::new(Some(&mechanism), [0; 3]);
    assert!(!device.homed() && !device.show_home(&tip));
    assert!(device.show_home(&joints([9, 0, 0], 1)));
    assert_eq!(device.sensed(&tip).status, SensorStatus::Failed);
    assert!(!device.homed(), "whatever counted the joints has gone");
    let mut unchecked = mechanism;
    unchecked.dimensions[0] = f32::NAN;
    let mut device = Device::new(Some(&unchecked), [0; 3]);
    assert_eq!(device.sensed(&joints([0; 3], 1)).status, SensorStatus::Failed);
    assert_eq!(device.outputs(ActuatorCommand::Force(palpate::Vector3::z())), Outputs::OFF);
}
