//! Every mechanism: its torques are the transpose of the derivative of its tip, by finite
//! differences, so motors and hand have the same power.

use nalgebra::Vector3;
use palpate_controller::kinematics::{Mechanism, Paddle, Pantograph, YourDevice};
use palpate_controller::probe_in::EncoderCounts;

/// Counts that a joint is moved for a difference, to both sides.
const STEP: i32 = 50;

/// `tau . q'` against `F . x'` for each joint moved alone, in three directions of force: relative
/// to the largest power met.
fn power_is_kept<M: Mechanism + Clone>(mechanism: &M, poses: &[[i32; 3]], joints: usize, per_count: [f32; 3]) {
    let mut met = 0;
    for pose in poses {
        let mut here = mechanism.clone();
        assert!(here.tip_m(pose.map(EncoderCounts)).is_some(), "{pose:?} is no pose");
        for force_n in [Vector3::x(), Vector3::z(), Vector3::new(0.6, 0.3, -1.1)] {
            let torques = here.torques_n_m(force_n);
            for joint in 0..joints {
                let moved = |by: i32| {
                    let mut counts = *pose;
                    counts[joint] += by;
                    mechanism.clone().tip_m(counts.map(EncoderCounts)).unwrap().cast::<f64>()
                };
                let turned = f64::from(2 * STEP) * f64::from(per_count[joint]);
                let slope = (moved(STEP) - moved(-STEP)) / turned;
                let (motor, hand) = (f64::from(torques[joint]), force_n.cast::<f64>().dot(&slope));
                let scale = slope.norm().max(1e-3) * f64::from(force_n.norm());
                assert!((motor - hand).abs() < 4e-3 * scale, "{pose:?}, joint {joint}, {force_n:?}: {motor} and {hand}");
                met += usize::from(hand.abs() > 0.1 * scale);
            }
        }
    }
    assert!(met > poses.len(), "no force met a motion: nothing was proved");
}

/// 8192 counts a turn.
const RAD_PER_COUNT: f32 = core::f32::consts::TAU / 8192.0;

/// That of Campion, Wang and Hayward: 63, 75 and 25 mm, its centre in the middle of the workspace.
fn pantograph() -> Pantograph {
    Pantograph::new([0.063, 0.075], 0.025, RAD_PER_COUNT, [1.2, 1.94], [-0.0125, 0.11])
}

#[test]
fn a_paddle() {
    let poses: Vec<[i32; 3]> = (-4..=4).map(|n| [200 * n, 0, 0]).collect();
    power_is_kept(&Paddle::new(0.09, RAD_PER_COUNT), &poses, 1, [RAD_PER_COUNT; 3]);
    // level, it lifts with all its arm
    let mut level = Paddle::new(0.09, RAD_PER_COUNT);
    assert_eq!(level.tip_m([EncoderCounts(0); 3]), Some(Vector3::zeros()));
    assert_eq!(level.torques_n_m(Vector3::new(0.0, 5.0, 2.0)), [0.18, 0.0, 0.0]);
}

#[test]
fn a_pantograph() {
    let poses: Vec<[i32; 3]> = (-3..=3).flat_map(|a| (-3..=3).map(move |b| [120 * a, 120 * b, 0])).collect();
    power_is_kept(&pantograph(), &poses, 2, [RAD_PER_COUNT; 3]);
}

#[test]
fn the_arms_of_a_pantograph_keep_their_lengths() {
    for pose in [[0, 0, 0], [300, -200, 0], [-350, 150, 0], [100, 400, 0]] {
        let mut device = pantograph();
        let tip = device.tip_m(pose.map(EncoderCounts)).unwrap();
        let tip = [f64::from(tip.x + device.centre_m[0]), f64::from(tip.z + device.centre_m[1])];
        let at = |joint: usize, base: f64| {
            let q = f64::from(device.zero_rad[joint]) + f64::from(pose[joint]) * f64::from(RAD_PER_COUNT);
            [0.063 * q.cos() - base, 0.063 * q.sin()]
        };
        for elbow in [at(0, 0.0), at(1, 0.025)] {
            let far = (tip[0] - elbow[0]).hypot(tip[1] - elbow[1]);
            assert!((far - 0.075).abs() < 1e-6, "{pose:?}: {far} m");
        }
        assert!(tip[1] > 0.063, "{pose:?}: the tip is above the elbows: {tip:?}");
    }
}

#[test]
fn joints_that_cannot_be_are_no_pose_and_give_no_torque() {
    // elbows 151 mm apart: the distal arms do not reach
    let mut device = Pantograph::new([0.063, 0.075], 0.025, RAD_PER_COUNT, [0.0, core::f32::consts::PI], [0.0; 2]);
    assert_eq!(device.tip_m([EncoderCounts(0); 3]), None);
    assert_eq!(device.torques_n_m(Vector3::new(1.0, 1.0, 1.0)), [0.0; 3]);
}

#[test]
fn arms_that_lie_on_each_other_give_no_torque_and_those_beside_it_little() {
    let folded = (0.0125_f32 / 0.063).acos();
    for apart in [1e-4_f32, 1e-3, 0.03, 0.1, 0.2, 0.4] {
        let joints = [core::f32::consts::PI - folded - apart, folded + apart];
        let mut device = Pantograph::new([0.063, 0.075], 0.025, RAD_PER_COUNT, joints, [0.0; 2]);
        let tip = device.tip_m([EncoderCounts(0); 3]);
        let most = device.torques_n_m(Vector3::new(1.0, 0.0, 1.0)).into_iter().fold(0.0_f32, |most, t| most.max(t.abs()));
        println!("{apart} rad: {tip:?}, {most} N m");
        assert!(most < 10.0 * 0.063 * 2.0_f32.sqrt(), "{apart} rad: {most} N m for 1.4 N");
        assert_eq!(tip.is_some(), apart >= 0.1, "{apart} rad");
    }
}

#[test]
fn the_template() {
    let m_per_rad = 5e-3_f32;
    let device = YourDevice { m_per_count: [m_per_rad * RAD_PER_COUNT; 3], m_per_rad: [m_per_rad; 3] };
    power_is_kept(&device, &[[0, 0, 0], [1_000, -2_000, 500]], 3, [RAD_PER_COUNT; 3]);
}
