//! For every mechanism, torques are compared with the transpose of the Jacobian of the tip position
//! by finite differences: motors and hand must have the same power.

use palpate::Vector3;
use palpate_controller::kinematics::{DIMENSIONS, Mechanism, Paddle, Pantograph};

/// Angle by which a joint is turned to either side for a difference [rad].
const STEP_RAD: f32 = 0.02;

/// Compares `tau . q'` with `F . x'` for each joint turned alone and three directions of force,
/// relative to the largest power that occurs. `poses_rad` are joint angles.
pub fn power_is_kept<M: Mechanism + Clone>(mechanism: &M, poses_rad: &[[f32; 3]]) {
    let mut met = 0;
    for pose in poses_rad {
        let mut here = mechanism.clone();
        assert!(here.tip_m(*pose).is_some(), "{pose:?} is no pose");
        for force_n in [Vector3::x(), Vector3::z(), Vector3::new(0.6, 0.3, -1.1)] {
            let torques = here.torques_n_m(force_n);
            assert_eq!(torques[M::JOINTS..], [0.0; 3][M::JOINTS..], "a joint that is not there has no torque");
            for joint in 0..M::JOINTS {
                let moved = |by: f32| {
                    let mut joints = *pose;
                    joints[joint] += by;
                    mechanism.clone().tip_m(joints).unwrap().cast::<f64>()
                };
                let slope = (moved(STEP_RAD) - moved(-STEP_RAD)) / f64::from(2.0 * STEP_RAD);
                let (motor, hand) = (f64::from(torques[joint]), force_n.cast::<f64>().dot(&slope));
                let scale = slope.norm().max(1e-3) * f64::from(force_n.norm());
                assert!((motor - hand).abs() < 4e-3 * scale, "{pose:?}, joint {joint}, {force_n:?}: {motor} and {hand}");
                met += usize::from(hand.abs() > 0.1 * scale);
            }
        }
    }
    assert!(met > poses_rad.len(), "no force met a motion: nothing was proved");
}

/// The pantograph of Campion, Wang and Hayward with lengths of 63, 75 and 25 mm, its centre in the
/// middle of the workspace.
fn pantograph() -> Pantograph {
    Pantograph::build([0.063, 0.075, 0.025, -0.0125, 0.11]).unwrap()
}

/// Joint angles in the middle of the workspace [rad].
const MIDDLE_RAD: [f32; 2] = [1.2, 1.94];

#[test]
fn a_paddle() {
    let poses: Vec<[f32; 3]> = (-4..=4).map(|n| [0.15 * n as f32, 0.0, 0.0]).collect();
    let paddle = Paddle::build([0.09, 0.0, 0.0, 0.0, 0.0]).unwrap();
    power_is_kept(&paddle, &poses);
    // when level, the paddle lifts with its full arm
    let mut level = paddle;
    assert_eq!(level.tip_m([0.0; 3]), Some(Vector3::zeros()));
    assert_eq!(level.torques_n_m(Vector3::new(0.0, 5.0, 2.0)), [0.18, 0.0, 0.0]);
    assert_eq!(level.tip_m([1.7, 0.0, 0.0]), None, "beyond upright");
}

#[test]
fn a_pantograph() {
    let [a, b] = MIDDLE_RAD;
    let poses: Vec<[f32; 3]> =
        (-3..=3).flat_map(|m| (-3..=3).map(move |n| [a + 0.09 * m as f32, b + 0.09 * n as f32, 0.0])).collect();
    power_is_kept(&pantograph(), &poses);
}

#[test]
fn the_arms_of_a_pantograph_keep_their_lengths() {
    for turned in [[0.0, 0.0], [0.23, -0.15], [-0.27, 0.12], [0.08, 0.31]] {
        let mut device = pantograph();
        let joints = [MIDDLE_RAD[0] + turned[0], MIDDLE_RAD[1] + turned[1], 0.0];
        let tip = device.tip_m(joints).unwrap();
        let tip = [f64::from(tip.x + device.centre_m[0]), f64::from(tip.z + device.centre_m[1])];
        let at = |joint: usize, base: f64| {
            let q = f64::from(joints[joint]);
            [0.063 * q.cos() - base, 0.063 * q.sin()]
        };
        for elbow in [at(0, 0.0), at(1, 0.025)] {
            let far = (tip[0] - elbow[0]).hypot(tip[1] - elbow[1]);
            assert!((far - 0.075).abs() < 1e-6, "{turned:?}: {far} m");
        }
        assert!(tip[1] > 0.063, "{turned:?}: the tip is above the elbows: {tip:?}");
    }
}

#[test]
fn joints_that_cannot_be_are_no_pose_and_give_no_torque() {
    // elbows 151 mm apart: the distal arms do not reach
    let mut device = pantograph();
    assert_eq!(device.tip_m([0.0, core::f32::consts::PI, 0.0]), None);
    assert_eq!(device.torques_n_m(Vector3::new(1.0, 1.0, 1.0)), [0.0; 3]);
}

#[test]
fn arms_that_lie_on_each_other_give_no_torque_and_those_beside_it_little() {
    let folded = (0.0125_f32 / 0.063).acos();
    for apart in [1e-4_f32, 1e-3, 0.03, 0.1, 0.2, 0.4] {
        let mut device = pantograph();
        let tip = device.tip_m([core::f32::consts::PI - folded - apart, folded + apart, 0.0]);
        let most = device.torques_n_m(Vector3::new(1.0, 0.0, 1.0)).into_iter().fold(0.0_f32, |most, t| most.max(t.abs()));
        println!("{apart} rad: {tip:?}, {most} N m");
        assert!(most < 10.0 * 0.063 * 2.0_f32.sqrt(), "{apart} rad: {most} N m for 1.4 N");
        assert_eq!(tip.is_some(), apart >= 0.1, "{apart} rad");
    }
}

#[test]
fn dimensions_that_no_mechanism_has_are_refused() {
    let mut nan = [0.063, 0.075, 0.025, -0.0125, 0.11];
    for place in 0..DIMENSIONS {
        let before = std::mem::replace(&mut nan[place], f32::NAN);
        assert!(Pantograph::build(nan).is_err(), "dimension {place}");
        nan[place] = before;
    }
    for arm_m in [0.0, -0.09, f32::NAN, f32::INFINITY] {
        assert!(Paddle::build([arm_m, 0.0, 0.0, 0.0, 0.0]).is_err(), "{arm_m}");
    }
}
