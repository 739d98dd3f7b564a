//! The reach of the mechanisms, the dimensions that are possible, and the profiles that are
//! refused.

use palpate::Vector3;
use palpate::haptic::device::DeviceSpec;
use palpate_controller::kinematics::{
    DIMENSIONS, Kind, Mechanism, MechanismError, MechanismProfile, Paddle, Pantograph, YourDevice,
};

/// Lengths of the pantograph of Campion, Wang and Hayward [m]: motor to elbow, elbow to tip, motor
/// to motor.
const NEAR_M: f32 = 0.063;
const FAR_M: f32 = 0.075;
const BASE_M: f32 = 0.025;

/// That pantograph with its centre at a position in the frame of its first motor [m].
fn pantograph(centre_m: [f32; 2]) -> Pantograph {
    Pantograph::build([NEAR_M, FAR_M, BASE_M, centre_m[0], centre_m[1]]).unwrap()
}

/// A lever of 90 mm on a capstan, homed at 15 degrees.
pub fn paddle() -> MechanismProfile {
    MechanismProfile {
        kind: Kind::Paddle,
        rad_per_count: [1.278e-4, 0.0, 0.0],
        full_scale_n_m: [0.564, 0.0, 0.0],
        home_rad: [0.2618, 0.0, 0.0],
        dimensions: [0.09, 0.0, 0.0, 0.0, 0.0],
        homing: true,
    }
}

/// Limits of the device on that lever.
pub fn paddle_spec() -> DeviceSpec {
    DeviceSpec {
        max_force_n: 5.0,
        workspace_low_m: Vector3::new(-0.03, -0.03, -0.05),
        workspace_high_m: Vector3::new(0.03, 0.03, 0.05),
        // along z, at 15 degrees
        count_m: 0.086_933 * 1.278e-4,
        delay_ticks: 1,
        lag_s: 0.0,
        mass_kg: 0.045,
        stiffness_ceiling_n_per_m: 1e5,
        commissioned: true,
    }
}

fn checked(change: impl FnOnce(&mut MechanismProfile, &mut DeviceSpec)) -> Result<(), MechanismError> {
    let (mut profile, mut spec) = (paddle(), paddle_spec());
    change(&mut profile, &mut spec);
    profile.check(&spec)
}

#[test]
fn a_pantograph_reaches_where_neither_arm_is_stretched_or_folded() {
    let device = pantograph([0.0, 0.0]);
    let at = |x: f32, z: f32| device.reaches(Vector3::new(x, 0.0, z));
    assert!(at(-0.0125, 0.11) && at(0.0, 0.13) && at(-BASE_M, 0.13));
    assert!(!at(-0.0125, -0.11) && !at(0.0, -0.05), "below the motors");
    assert!(!at(0.05, 0.125) && !at(-0.075, 0.125), "beyond one arm and within the other");
    assert!(at(0.0, 0.013) && !at(0.0, 0.011) && !at(-BASE_M, 0.011), "too near to one motor");
    // above the first motor by the length of both arms, less 3 mm and plus 1 mm
    assert!(at(0.0, NEAR_M + FAR_M - 3e-3) && !at(0.0, NEAR_M + FAR_M + 1e-3));
    let device = pantograph([-0.0125, 0.11]);
    let from_centre = |x: f32, z: f32| device.reaches(Vector3::new(x, 0.0, z));
    assert!(from_centre(0.055, 0.0) && from_centre(-0.055, 0.0) && from_centre(0.0, -0.1));
    assert!(!from_centre(0.08, 0.0) && !from_centre(-0.08, 0.0) && !from_centre(0.0, 0.03) && !from_centre(0.0, -0.12));
}

#[test]
fn an_almost_stretched_pantograph_has_no_pose() {
    for (share, posed) in [(0.5e-3_f32, false), (2e-3, true)] {
        // the elbows' distance at which the tip's squared height above them is `share` of the
        // squared distal arm
        let apart_m = 2.0 * FAR_M * (1.0 - share).sqrt();
        let angle = (0.5 * (apart_m - BASE_M) / NEAR_M).acos();
        let mut device = pantograph([0.0, 0.0]);
        let tip_m = device.tip_m([angle, std::f32::consts::PI - angle, 0.0]);
        assert_eq!(tip_m.is_some(), posed, "{share}");
        let given = device.torques_n_m(Vector3::new(1.0, 1.0, 1.0)) != [0.0; 3];
        assert_eq!(given, posed, "{share}");
    }
}

#[test]
fn a_tip_lies_where_its_joints_put_it() {
    let mut lever = Paddle::build([0.09, 0.0, 0.0, 0.0, 0.0]).unwrap();
    for degrees in [-80.0_f32, -30.0, 10.0, 30.0, 80.0] {
        let angle = degrees.to_radians();
        let right_m = Vector3::new(0.09 * (angle.cos() - 1.0), 0.0, 0.09 * angle.sin());
        assert!((lever.tip_m([angle, 1.0, 1.0]).unwrap() - right_m).norm() < 1e-6, "{degrees}");
    }
    assert_eq!(lever.tip_m([-1.6, 0.0, 0.0]), None, "beyond vertical");
    assert!(lever.reaches(Vector3::new(0.0, 0.0, 0.089)) && lever.reaches(Vector3::new(0.0, 0.0, -0.089)));
    assert!(!lever.reaches(Vector3::new(0.0, 0.0, 0.091)) && !lever.reaches(Vector3::new(0.0, 0.0, -0.091)));
    let mut spindles = YourDevice::build([5e-3, 4e-3, 6e-3, 0.0, 0.0]).unwrap();
    let tip_m = spindles.tip_m([1.0, -2.0, 3.0]).unwrap();
    assert!((tip_m - Vector3::new(5e-3, -8e-3, 18e-3)).norm() < 1e-8, "{tip_m}");
    let torques = spindles.torques_n_m(Vector3::new(2.0, 3.0, -1.0));
    assert!((Vector3::from(torques) - Vector3::new(10e-3, 12e-3, -6e-3)).norm() < 1e-8, "{torques:?}");
    assert!(spindles.reaches(Vector3::repeat(0.05)));
}

#[test]
fn one_dimension_alone_makes_a_mechanism_impossible() {
    let right = [NEAR_M, FAR_M, BASE_M, -0.0125, 0.11];
    assert!(Pantograph::build(right).is_ok());
    for (place, wrong) in
        [(0, 0.004), (0, 1.1), (1, 0.004), (1, 1.1), (2, -0.01), (2, 1.1), (3, 2.1), (3, -2.1), (4, 2.1), (4, -2.1)]
    {
        let mut dimensions = right;
        dimensions[place] = wrong;
        assert_eq!(Pantograph::build(dimensions).err(), Some(MechanismError::Arms), "{place}: {wrong}");
    }
    for wrong in [0.004, 1.1] {
        assert_eq!(Paddle::build([wrong, 0.0, 0.0, 0.0, 0.0]).err(), Some(MechanismError::Arms), "{wrong}");
    }
    for place in 0..3 {
        for wrong in [0.9e-5, 0.21, -5e-3, f32::NAN] {
            let mut leads = [5e-3, 5e-3, 5e-3, 0.0, 0.0];
            leads[place] = wrong;
            assert_eq!(YourDevice::build(leads).err(), Some(MechanismError::Arms), "{place}: {wrong}");
        }
    }
}

#[test]
fn a_kind_is_the_mechanism_of_its_name() {
    for (kind, name, joints, dimensions) in
        [(Kind::Paddle, "paddle", 1, 1), (Kind::Pantograph, "pantograph", 2, 5), (Kind::YourDevice, "your-device", 3, 3)]
    {
        assert_eq!((kind.name(), kind.joints(), kind.dimension_names().len()), (name, joints, dimensions));
    }
    // a linkage built by its kind computes the same as the paddle itself
    let (mut linkage, mut device) = (Kind::Paddle.build([0.09, 0.0, 0.0, 0.0, 0.0]).unwrap(), paddle_of());
    let joints = [0.4, 0.0, 0.0];
    assert_eq!(linkage.tip_m(joints), device.tip_m(joints));
    let force_n = Vector3::new(1.0, 2.0, 3.0);
    assert_eq!(linkage.torques_n_m(force_n), device.torques_n_m(force_n));
    assert!(linkage.reaches(Vector3::zeros()) && !linkage.reaches(Vector3::new(0.0, 0.0, 0.1)));
    assert_eq!(Kind::Pantograph.build([0.0; DIMENSIONS]).err(), Some(MechanismError::Arms));
}

fn paddle_of() -> Paddle {
    Paddle::build([0.09, 0.0, 0.0, 0.0, 0.0]).unwrap()
}

#[test]
fn a_profile_is_accepted_at_either_sign_of_its_encoders_and_motors() {
    assert_eq!(checked(|_, _| ()), Ok(()));
    assert_eq!(checked(|profile, _| profile.rad_per_count[0] *= -1.0), Ok(()));
    assert_eq!(checked(|profile, _| profile.full_scale_n_m[0] *= -1.0), Ok(()));
    assert_eq!(checked(|profile, _| profile.home_rad[0] *= -1.0), Ok(()));
}

#[test]
fn a_value_out_of_range_and_one_for_a_joint_that_is_not_there_are_refused_by_name() {
    use MechanismError::{Arms, Encoder, Home, Motor};
    type Spoil = fn(&mut MechanismProfile);
    let table: [(MechanismError, Spoil); 13] = [
        (Arms, |profile| profile.dimensions[0] = 2.0),
        (Encoder, |profile| profile.rad_per_count[0] = 0.11),
        (Encoder, |profile| profile.rad_per_count[0] = 0.9e-7),
        (Encoder, |profile| profile.rad_per_count[1] = 1e-4),
        (Encoder, |profile| profile.rad_per_count[2] = 1e-4),
        (Motor, |profile| profile.full_scale_n_m[0] = 101.0),
        (Motor, |profile| profile.full_scale_n_m[0] = 0.9e-4),
        (Motor, |profile| profile.full_scale_n_m[1] = 0.5),
        (Motor, |profile| profile.full_scale_n_m[2] = 0.5),
        (Home, |profile| profile.home_rad[1] = 0.1),
        (Home, |profile| profile.home_rad[0] = 6.4),
        (Home, |profile| profile.home_rad[0] = 1.6),
        (Home, |profile| profile.home_rad[0] = f32::NAN),
    ];
    for (n, (error, spoil)) in table.into_iter().enumerate() {
        assert_eq!(checked(|profile, _| spoil(profile)), Err(error), "{n}");
    }
}

#[test]
fn the_home_pose_lies_within_the_workspace_on_every_axis() {
    // the tip at home is at (-3.1, 0, 23.3) mm
    for (axis, low_m, high_m) in
        [(0, -2e-3, 0.03), (0, -0.03, -4e-3), (1, 1e-3, 0.03), (1, -0.03, -1e-3), (2, 0.024, 0.05), (2, -0.05, 0.022)]
    {
        let at = |spec: &mut DeviceSpec| (spec.workspace_low_m[axis], spec.workspace_high_m[axis]) = (low_m, high_m);
        assert_eq!(checked(|_, spec| at(spec)), Err(MechanismError::Home), "{axis}: {low_m} to {high_m}");
    }
    for (axis, low_m, high_m) in [(0, -4e-3, -2e-3), (2, 0.022, 0.024)] {
        let at = |spec: &mut DeviceSpec| (spec.workspace_low_m[axis], spec.workspace_high_m[axis]) = (low_m, high_m);
        assert_eq!(checked(|_, spec| at(spec)), Ok(()), "{axis}: {low_m} to {high_m}");
    }
}

#[test]
fn a_workspace_beyond_reach_motors_too_weak_and_another_count_are_refused() {
    use MechanismError::{Count, Force, Reach};
    assert_eq!(checked(|_, spec| spec.workspace_high_m.z = 0.091), Err(Reach));
    assert_eq!(checked(|_, spec| spec.workspace_low_m.z = -0.091), Err(Reach));
    assert_eq!(checked(|_, spec| spec.workspace_high_m.z = 0.089), Ok(()));
    // 5 N on a lever of 86.9 mm take 0.4347 N m
    for (full_n_m, taken) in [(0.436, Ok(())), (-0.436, Ok(())), (0.433, Err(Force)), (-0.433, Err(Force))] {
        assert_eq!(checked(|profile, _| profile.full_scale_n_m[0] = full_n_m), taken, "{full_n_m} N m");
    }
    assert_eq!(checked(|_, spec| spec.max_force_n = 6.6), Err(Force));
    for (times, taken) in [(1.09, Ok(())), (0.91, Ok(())), (1.11, Err(Count)), (0.89, Err(Count))] {
        assert_eq!(checked(|_, spec| spec.count_m *= times), taken, "{times}");
    }
}

#[test]
fn a_count_is_the_longest_way_along_an_axis_that_a_count_of_every_joint_gives() {
    assert!((paddle().count_m().unwrap() / (0.086_933 * 1.278e-4) - 1.0).abs() < 1e-5);
    assert_eq!(MechanismProfile { home_rad: [1.6, 0.0, 0.0], ..paddle() }.count_m(), None, "no such pose");
    assert_eq!(MechanismProfile { dimensions: [f32::NAN; DIMENSIONS], ..paddle() }.count_m(), None);
    let leads_m = [5e-3, 4e-3, 6e-3];
    for (rad_per_count, longest_m) in [([4e-3, 1e-3, 1e-3], 20e-6), ([1e-3, -7e-3, 1e-3], 28e-6), ([1e-3, 1e-3, 5e-3], 30e-6)] {
        let [x, y, z] = leads_m;
        let profile = MechanismProfile { kind: Kind::YourDevice, rad_per_count, dimensions: [x, y, z, 0.0, 0.0], ..paddle() };
        assert!((profile.count_m().unwrap() / longest_m - 1.0).abs() < 1e-5, "{rad_per_count:?}");
    }
    let home_rad = [1.2, 1.94, 0.0];
    for rad_per_count in [[2e-4, 5e-5, 0.0], [5e-5, 2e-4, 0.0]] {
        let dimensions = [NEAR_M, FAR_M, BASE_M, -0.0125, 0.11];
        let profile = MechanismProfile { kind: Kind::Pantograph, rad_per_count, home_rad, dimensions, ..paddle() };
        // by a finite difference over two hundred counts
        let at = |joint: usize, counts: f32| {
            let mut joints_rad = home_rad;
            joints_rad[joint] += counts * rad_per_count[joint];
            pantograph([-0.0125, 0.11]).tip_m(joints_rad).unwrap()
        };
        let way_m = |joint: usize| ((at(joint, 100.0) - at(joint, -100.0)) / 200.0).abs();
        let longest_m = (way_m(0) + way_m(1)).max();
        assert!((profile.count_m().unwrap() / longest_m - 1.0).abs() < 5e-3, "{rad_per_count:?}");
    }
}
