//! A device between pins and haptic cycle: conversion of counts to a tip position, and of a force
//! to converter codes.

use palpate::Vector3;
use palpate::haptic::cycle::{Ask, Command, Settings};
use palpate::haptic::device::{Sensed, SensorStatus};
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Fault};
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::device::Device;
use palpate_controller::force_out::{ActuatorCommand, DacCode, Outputs, outputs};
use palpate_controller::kinematics::{Kind, MechanismProfile};
use palpate_controller::port::Port;
use palpate_controller::probe_in::{EncoderCounts, JointReading, Reading};

use super::mechanisms::{paddle, paddle_spec};
use super::mock::Slab;

fn joints(counts: [i32; 3], sequence: u32, status: SensorStatus) -> Reading {
    Reading::Joints(JointReading { counts: counts.map(EncoderCounts), sequence, status })
}

fn good(counts: [i32; 3], sequence: u32) -> Reading {
    joints(counts, sequence, SensorStatus::Good)
}

/// Three spindles, the second of which has a motor with reversed sign.
fn spindles() -> MechanismProfile {
    MechanismProfile {
        kind: Kind::YourDevice,
        rad_per_count: [2e-3, -3e-3, 5e-3],
        full_scale_n_m: [0.05, -0.08, 0.06],
        home_rad: [0.5, 1.0, -2.0],
        dimensions: [5e-3, 4e-3, 6e-3, 0.0, 0.0],
        homing: true,
    }
}

#[test]
fn counts_are_turned_from_the_home_pose() {
    let mut device = Device::new(Some(&spindles()), [0; 3]);
    let home_m = Vector3::new(2.5e-3, 4e-3, -12e-3);
    assert!(!device.homed());
    let before = device.sensed(&good([300, 200, 100], 1));
    assert!((before.position_m - home_m).norm() < 1e-8, "taken to be at home: {before:?}");
    assert!(device.show_home(&good([10, 20, 30], 2)) && device.homed());
    assert!((device.sensed(&good([10, 20, 30], 3)).position_m - home_m).norm() < 1e-8);
    let moved = device.sensed(&good([110, 220, 0], 4));
    assert_eq!((moved.sequence, moved.status), (4, SensorStatus::Good));
    let right_m = home_m + Vector3::new(100.0 * 2e-3 * 5e-3, 200.0 * -3e-3 * 4e-3, -30.0 * 5e-3 * 6e-3);
    assert!((moved.position_m - right_m).norm() < 1e-7, "{moved:?}");
    // counters wrap
    assert!(device.show_home(&good([i32::MAX, i32::MIN, 0], 5)));
    let over = device.sensed(&good([i32::MIN, i32::MAX, 0], 6));
    assert!((over.position_m - home_m - Vector3::new(1e-5, 1.2e-5, 0.0)).norm() < 1e-7, "{over:?}");
}

#[test]
fn three_axes_count_from_their_home() {
    let mut device = Device::new(None, [100, -200, 300]);
    assert!(device.homed());
    let at = device.sensed(&good([200, -200, 0], 8));
    assert!((at.position_m - Vector3::new(1e-3, 0.0, -3e-3)).norm() < 1e-6, "{at:?}");
    assert_eq!((at.sequence, at.status), (8, SensorStatus::Good));
    assert_eq!(device.sensed(&joints([0; 3], 9, SensorStatus::Failed)).status, SensorStatus::Failed);
    let mut lost = device.without_home();
    assert!(!lost.homed());
    lost.sensed(&good([0; 3], 1));
    assert!(!lost.homed(), "counts tell no home");
    let tip = Sensed { position_m: Vector3::new(1.0, 2.0, 3.0), sequence: 5, status: SensorStatus::Good };
    assert_eq!(lost.sensed(&Reading::Tip(tip)), tip);
    assert!(lost.homed(), "a tip is in the device's frame");
    assert!(!lost.show_home(&joints([0; 3], 1, SensorStatus::Failed)), "of a failed sensor");
    let drive = ActuatorCommand::Force(Vector3::new(1.0, -2.0, 3.0));
    assert_eq!(device.outputs(drive), outputs(drive));
}

#[test]
fn torques_become_shares_of_the_converters_and_are_shortened_alike() {
    let mut device = Device::new(Some(&spindles()), [0; 3]);
    device.show_home(&good([0; 3], 1));
    device.sensed(&good([0; 3], 2));
    let codes = |force_n: [f32; 3]| device.outputs(ActuatorCommand::Force(force_n.into()));
    // 4 N on 5 mm take 20 of 50 mN m, 5 N on 4 mm 20 of -80, and 6 N on 6 mm 36 of 60
    let within = codes([4.0, 5.0, 6.0]);
    assert!(within.enabled);
    for (code, share) in within.codes.iter().zip([0.4, -0.25, 0.6]) {
        assert_eq!(*code, DacCode::from_share(share));
    }
    // the third axis needs twice its converter's range, so every share is halved
    let beyond = codes([8.0, 10.0, 20.0]);
    for (code, share) in beyond.codes.iter().zip([0.4, -0.25, 1.0]) {
        assert!((f32::from(code.0) - share * 32_767.0).abs() <= 1.0, "{beyond:?}");
    }
    for bad in [[f32::NAN, 1.0, 1.0], [1.0, f32::INFINITY, 1.0], [1.0, 1.0, f32::NEG_INFINITY]] {
        assert_eq!(codes(bad).codes, [DacCode::ZERO; 3], "{bad:?}");
    }
    assert_eq!(device.outputs(ActuatorCommand::Off), Outputs::OFF);
}

#[test]
fn a_joint_without_a_motor_gets_no_code() {
    let mut device = Device::new(Some(&paddle()), [0; 3]);
    device.show_home(&good([0; 3], 1));
    device.sensed(&good([0; 3], 2));
    let codes = device.outputs(ActuatorCommand::Force(Vector3::new(0.0, 2.0, 1.0))).codes.map(|code| code.0);
    // 1 N on a lever of 86.9 mm, of 564 mN m at full scale
    assert!((f32::from(codes[0]) / 32_767.0 - 0.0869 / 0.564).abs() < 1e-3, "{codes:?}");
    assert_eq!(codes[1..], [0, 0]);
}

#[test]
fn impossible_joints_a_failed_sensor_and_a_bare_tip_lose_the_home_of_a_mechanism_that_is_homed() {
    let tip = Reading::Tip(Sensed { position_m: Vector3::zeros(), sequence: 7, status: SensorStatus::Good });
    // 2 rad: beyond vertical
    for bad in [good([15_650, 0, 0], 7), joints([0; 3], 7, SensorStatus::Failed), tip] {
        for homing in [true, false] {
            let mut device = Device::new(Some(&MechanismProfile { homing, ..paddle() }), [0; 3]);
            assert_eq!(device.homed(), !homing);
            assert!(device.show_home(&good([0; 3], 1)));
            let failed = Sensed { position_m: Vector3::zeros(), sequence: 7, status: SensorStatus::Failed };
            assert_eq!(device.sensed(&bad), failed);
            assert_eq!(device.homed(), !homing, "{bad:?}");
        }
    }
}

/// A paddle that is armed and presses a slab; returns the counts of the pose and the last sequence
/// number.
fn pressing() -> (Controller, i32, u32) {
    let port = Port::with_limits(paddle_spec()).with_device(Device::new(Some(&paddle()), [0; 3]));
    let settings = Settings::safe(&paddle_spec());
    let mut controller = Controller::build(&settings, port, Arming::ByItself).unwrap();
    let counts = |z_m: f32| (((z_m / 0.09).asin() - 0.2618) / 1.278e-4).round() as i32;
    let (mut n, mut sequence) = (0, 0);
    let mut to = |controller: &mut Controller, z_m: f32, ticks: u32| {
        let from = n;
        for tick in 1..=ticks {
            n = from + ((counts(z_m) - from) as f32 * (tick as f32 / ticks as f32)) as i32;
            sequence += 1;
            let reading = good([n, 0, 0], sequence);
            if sequence == 10 {
                assert!(controller.show_home(&good([0; 3], 0)));
            }
            let record = controller.tick(&mut Slab, reading, Command::HEARD, true);
            assert_eq!(record.fault, None, "tick {sequence}");
        }
    };
    to(&mut controller, 0.09 * 0.2618_f32.sin(), 20);
    to(&mut controller, 3e-3, 600);
    to(&mut controller, 3e-3, 1_500);
    assert_eq!(controller.mode(), Mode::Active);
    to(&mut controller, -2e-3, 500);
    to(&mut controller, -2e-3, 200);
    (controller, counts(-2e-3), sequence)
}

#[test]
fn a_jump_of_a_joint_changes_no_torque_and_a_dead_encoder_loses_the_home_pose() {
    let (mut controller, counts, mut sequence) = pressing();
    let before = controller.outputs();
    assert!(before.enabled && before.codes[0].0 > 2_000, "{before:?}");
    let mut tick = |controller: &mut Controller, counts: i32, status, asked| {
        sequence += 1;
        controller.tick(&mut Slab, joints([counts, 0, 0], sequence, status), Command { asked, ..Command::HEARD }, true)
    };
    // a jump by 1.2 rad, to where the lever arm is less than half as long
    let record = tick(&mut controller, counts + 9_390, SensorStatus::Good, None);
    assert!(record.limiters.contains(ClampFlags::HELD) && record.fault.is_none(), "{record:?}");
    let off = f32::from(controller.outputs().codes[0].0) / f32::from(before.codes[0].0) - 1.0;
    assert!(off.abs() < 0.05, "the torque of a joint that is not believed: {off}");
    assert!(controller.homed());
    let fault = (0..200).find_map(|_| tick(&mut controller, counts, SensorStatus::Failed, None).fault);
    assert_eq!(fault, Some(Fault::SensorFault));
    assert!(!controller.homed());
    tick(&mut controller, counts, SensorStatus::Good, Some(Ask::Clear));
    (0..50).for_each(|_| _ = tick(&mut controller, counts, SensorStatus::Good, Some(Ask::Arm)));
    assert!(matches!(controller.mode(), Mode::Idle | Mode::Fault), "{:?}", controller.mode());
}
