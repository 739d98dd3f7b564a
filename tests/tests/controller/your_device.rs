//! Template for the tests of a new device. Copy this file together with
//! `firmware/controller/src/kinematics/your_device.rs`, and change name, poses and profile.

use palpate_controller::kinematics::{Mechanism, YourDevice};
use palpate_sim::port::device_file;
use palpate_tests::palpate_command::repository;

use super::kinematics_keep_power::power_is_kept;

/// 1. Torques and tip position are consistent: joint angles all over the workspace [rad].
#[test]
fn it_keeps_power() {
    let device = YourDevice::build([5e-3, 4e-3, 6e-3, 0.0, 0.0]).unwrap();
    power_is_kept(&device, &[[0.0; 3], [1.0, -2.0, 0.5], [-8.0, 3.0, 7.0]]);
}

/// 2. A board accepts the profile: `palpate board profile` makes the same checks.
#[test]
fn a_board_takes_its_profile() {
    let file = repository().join("firmware/controller/devices/your-device.toml");
    let (device, profile) = device_file::load(file.to_str().unwrap()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(profile.mechanism.map(|it| it.kind.name()), Some(YourDevice::NAME));
    assert!(device.count_m > 0.0);
}
