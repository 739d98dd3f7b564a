//! Readings that jump across the surface.

use palpate::Vector3;

use crate::haptic_session::{HapticSession, Input};

/// Number of ticks of a tap before it touches.
const TICKS: u16 = 30;

/// Forces in the tick in which the tip is first in the tissue, this deep, and in the next ones,
/// where it rests there [N].
fn forces_n(from: impl Fn(u16) -> f32, depth_m: f32) -> [f32; 6] {
    let mut session = HapticSession::open("block", None, "touch").unwrap();
    session.arm().unwrap();
    let mut at = |height_m: f32| session.tick(&Input::at(Vector3::new(0.0, 0.0, height_m))).applied_n.z;
    for _ in 0..1500 {
        at(from(0));
    }
    (1..TICKS).for_each(|n| assert_eq!(at(from(n)), 0.0));
    [(); 6].map(|()| at(-depth_m))
}

#[test]
fn a_jump_of_a_millimetre_gives_no_more_than_a_tap_and_only_for_its_tick() {
    for depth_m in [0.1e-3, 0.5e-3, 0.9e-3] {
        let jump = forces_n(|_| 1e-3 - depth_m, depth_m);
        // 1 m/s: the last two readings are those of the jump
        let tap = forces_n(|n| 1e-3 * f32::from(TICKS - n) - depth_m, depth_m);
        // where both are cut off at the limit, they differ by rounding
        let most_n = tap[0] + 1e-6;
        assert!(jump[0] > 0.0 && jump[0] <= most_n, "{depth_m} m deep: {} N, a tap {} N", jump[0], tap[0]);
        assert!(jump[1..].iter().all(|next| *next < 0.1 * jump[0]), "{depth_m} m deep: {jump:?}");
    }
}
