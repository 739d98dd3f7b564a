//! The geometric check detects the violations for which it is made, in constructed forces and
//! readings.

use std::sync::Arc;

use palpate::Vector3;
use palpate::haptic::device::{Sensed, SensorStatus};
use palpate_loop::closed_loop::watch::{ByGeometry, HalfSpace};

/// Checks ticks with a tip height [m] and a force [N] over a surface at z = 0 with tissue below it;
/// returns the first violation.
fn judged(ticks: impl IntoIterator<Item = (f32, Vector3<f32>)>) -> Option<&'static str> {
    let mut watch = ByGeometry::over(Arc::new(HalfSpace { at_m: Vector3::zeros(), normal: Vector3::z() }));
    ticks.into_iter().enumerate().find_map(|(n, (z_m, force_n))| {
        let position_m = Vector3::new(0.0, 0.0, z_m);
        let reading = Sensed { position_m, sequence: n as u32, status: SensorStatus::Good };
        watch.check(&reading, force_n).err().map(|broken| broken.id)
    })
}

fn up_n(newton: f32) -> Vector3<f32> {
    Vector3::new(0.0, 0.0, newton)
}

#[test]
fn a_force_two_millimetres_outside_is_seen_at_the_sixth_tick_however_it_comes_and_goes() {
    assert_eq!(judged([(2e-3, up_n(0.5)); 5]), None);
    assert_eq!(judged([(2e-3, up_n(0.5)); 6]), Some("I12"));
    let pulsed = |n: i32| (2e-3, if n % 2 == 0 { up_n(0.5) } else { up_n(0.0) });
    assert_eq!(judged((0..20).map(pulsed)), Some("I12"));
    // the tip returns to the surface in between, which restarts the count
    let touching = |n: i32| (if n % 6 < 3 { 2e-3 } else { 0.0 }, up_n(if n % 6 < 3 { 0.5 } else { 0.0 }));
    assert_eq!(judged((0..60).map(touching)), None);
    assert_eq!(judged([(0.5e-3, up_n(0.5)); 50]), None, "within a millimetre");
}

#[test]
fn a_force_into_the_tissue_is_seen_and_one_out_of_it_or_along_it_is_not() {
    let press = |force_n: Vector3<f32>| judged([(1e-3, up_n(0.0)), (0.2e-3, up_n(0.0)), (-1e-3, force_n), (-2e-3, force_n)]);
    assert_eq!(press(up_n(-0.03)), Some("I13"));
    assert_eq!(press(up_n(-0.01)), None, "within what rounding of normals makes");
    assert_eq!(press(up_n(3.0)), None);
    assert_eq!(press(Vector3::new(1.0, 0.0, 0.0)), None);
}

#[test]
fn a_force_that_turns_round_at_rest_is_seen_and_one_that_moves_with_the_hand_is_not() {
    let shaking = |n: i32| up_n(if n % 2 == 0 { 1.0 } else { 1.05 });
    assert_eq!(judged((0..300).map(|n| (-1e-3, shaking(n)))), Some("I14"));
    assert_eq!(judged((0..240).map(|n| (-1e-3, shaking(n)))), None, "a stop may ring");
    assert_eq!(judged((0..300).map(|n| (-1e-3 - 1e-5 * n as f32, shaking(n)))), None, "the tip moves");
    assert_eq!(judged((0..300).map(|n| (-1e-3, up_n(1.0 + 0.05 * n as f32)))), None, "the force grows");
}
