//! A hand on the joints of a mechanism: encoder counts for a tip position, from kinematics that are
//! independent of the controller's.

use nalgebra::{Matrix3, Vector3};
use palpate_controller::kinematics::{Kind, MechanismProfile};

/// Tip position for joint angles [m], in double precision and with formulas that differ from the
/// controller's.
///
/// # Panics
/// Panics if the arms of a pantograph do not meet.
pub fn tip_m(mechanism: &MechanismProfile, [q1, q2, q3]: [f64; 3]) -> Vector3<f64> {
    let [a, b, c, d, e] = mechanism.dimensions.map(f64::from);
    match mechanism.kind {
        Kind::Paddle => Vector3::new(a * q1.cos() - a, 0.0, a * q1.sin()),
        Kind::Pantograph => {
            // the upper intersection of two circles of radius b around the elbows
            let (first, second) = ([a * q1.cos(), a * q1.sin()], [a * q2.cos() - c, a * q2.sin()]);
            let (dx, dz) = (first[0] - second[0], first[1] - second[1]);
            let apart = dx.hypot(dz);
            let half_angle = (apart / (2.0 * b)).acos();
            assert!(half_angle.is_finite(), "the arms do not meet");
            let towards = dz.atan2(dx);
            Vector3::new(second[0] + b * (towards + half_angle).cos() - d, 0.0, second[1] + b * (towards + half_angle).sin() - e)
        }
        Kind::YourDevice => Vector3::new(a * q1, b * q2, c * q3),
    }
}

/// Derivative of the tip position with respect to the joint angles, by central differences: one
/// column per joint [m].
pub fn jacobian_m(mechanism: &MechanismProfile, joints_rad: [f64; 3]) -> Matrix3<f64> {
    const STEP_RAD: f64 = 1e-5;
    let column = |joint: usize| {
        if joint >= mechanism.kind.joints() {
            return Vector3::zeros();
        }
        let moved = |by: f64| {
            let mut joints = joints_rad;
            joints[joint] += by;
            tip_m(mechanism, joints)
        };
        (moved(STEP_RAD) - moved(-STEP_RAD)) / (2.0 * STEP_RAD)
    };
    Matrix3::from_columns(&[column(0), column(1), column(2)])
}

/// Joint angles for encoder counts since the home pose [rad].
pub fn joints_rad(mechanism: &MechanismProfile, counts: [i32; 3]) -> [f64; 3] {
    std::array::from_fn(|joint| {
        f64::from(mechanism.home_rad[joint]) + f64::from(counts[joint]) * f64::from(mechanism.rad_per_count[joint])
    })
}

/// Encoder counts since the home pose that bring the tip nearest to a position [m].
pub fn counts_at(mechanism: &MechanismProfile, place_m: Vector3<f64>) -> [i32; 3] {
    let mut joints = mechanism.home_rad.map(f64::from);
    for _ in 0..30 {
        let jacobian = jacobian_m(mechanism, joints);
        let normal = jacobian.transpose() * jacobian + Matrix3::identity() * 1e-12;
        let step = normal.try_inverse().expect("a pose that is not singular")
            * (jacobian.transpose() * (place_m - tip_m(mechanism, joints)));
        joints.iter_mut().zip(step.iter()).for_each(|(joint, by)| *joint += by);
    }
    std::array::from_fn(|joint| {
        let step = f64::from(mechanism.rad_per_count[joint]);
        if step == 0.0 { 0 } else { ((joints[joint] - f64::from(mechanism.home_rad[joint])) / step).round() as i32 }
    })
}
