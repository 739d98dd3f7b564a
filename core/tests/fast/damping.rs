//! Damping acts in contact alone and along the normal alone, never pulls, and never lags.

use palpate::haptic::damping::{Damping, DampingSettings, MOST_N_S_PER_M, hertz_slope_n_per_m};
use palpate::haptic::seen::Shaper;
use palpate::{Output, Vector3};

use crate::bench::{TICK_S, pushing};

/// Damping that has tracked this velocity until its estimate settled.
fn moving(settings: DampingSettings, m_per_s: Vector3<f32>, count_m: f32) -> Damping {
    let mut damping = Damping::build(&settings, TICK_S, count_m).unwrap();
    (0..300_u16).for_each(|n| damping.track(m_per_s * (TICK_S * f32::from(n)), 1.0 / TICK_S));
    damping
}

/// Settings with this damping per tangent stiffness [s] and no constant part.
fn tangent_only(tau_s: f32) -> DampingSettings {
    DampingSettings { tau_s, ..DampingSettings::NONE }
}

#[test]
fn the_velocity_is_that_of_the_poses() {
    for m_per_s in [Vector3::new(0.1, -0.2, 0.3), Vector3::new(-0.4, 0.0, -0.01)] {
        let found = moving(DampingSettings::safe(1e-3, TICK_S), m_per_s, 0.0).velocity_m_per_s();
        assert!((found - m_per_s).norm() < 1e-3, "{found}");
    }
    let mut damping = Damping::build(&DampingSettings::NONE, TICK_S, 0.0).unwrap();
    damping.track(Vector3::new(1.0, 1.0, 1.0), 1.0 / TICK_S);
    assert_eq!(damping.velocity_m_per_s(), Vector3::zeros(), "one pose is no motion");
}

#[test]
fn the_low_pass_takes_its_share_of_the_newest_velocity() {
    // 0.2 m/s is less than a count per tick: only the low-pass acts
    let settings = DampingSettings { velocity_share: 0.25, ..DampingSettings::NONE };
    let mut damping = Damping::build(&settings, TICK_S, 0.5e-3).unwrap();
    damping.track(Vector3::zeros(), 1.0 / TICK_S);
    damping.track(Vector3::new(-0.2e-3, 0.0, 0.0), 1.0 / TICK_S);
    assert!((damping.velocity_m_per_s().x + 0.25 * 0.2).abs() < 1e-5, "{}", damping.velocity_m_per_s());
    damping.track(Vector3::new(-0.4e-3, 0.0, 0.0), 1.0 / TICK_S);
    assert!((damping.velocity_m_per_s().x + (0.25 + 0.75 * 0.25) * 0.2).abs() < 1e-5);
}

#[test]
fn the_velocity_lags_by_no_more_than_a_count_per_tick() {
    let count_m = 50e-6;
    let most = count_m / TICK_S;
    for m_per_s in [Vector3::new(0.0, 0.0, 1.0), Vector3::new(-0.8, 0.5, 0.0)] {
        let mut damping = moving(DampingSettings::safe(1e-3, TICK_S), m_per_s, count_m);
        let end_m = m_per_s * (TICK_S * 299.0);
        damping.track(end_m, 1.0 / TICK_S);
        for axis in 0..3 {
            assert!(damping.velocity_m_per_s()[axis].abs() <= most * 1.001, "stopped dead: {}", damping.velocity_m_per_s());
        }
        damping.track(end_m - m_per_s * TICK_S, 1.0 / TICK_S);
        let behind = damping.velocity_m_per_s() + m_per_s;
        assert!(behind.iter().all(|v| v.abs() <= most * 1.25), "turned round: {behind}");
    }
}

#[test]
fn a_finer_encoder_lets_the_velocity_lag_less() {
    // 0.5 mm of travel, then back: the lag after the reversal is in proportion to the count
    for count_m in [5e-6, 20e-6, 80e-6] {
        let mut damping = moving(DampingSettings::safe(1e-3, TICK_S), Vector3::new(0.0, 0.0, 0.05), count_m);
        let end_m = 0.05 * TICK_S * 299.0;
        damping.track(Vector3::new(0.0, 0.0, end_m - 0.3 * TICK_S), 1.0 / TICK_S);
        let behind = (damping.velocity_m_per_s().z + 0.3).abs();
        assert!(behind <= 1.25 * count_m / TICK_S, "{count_m} m: {behind} m/s behind");
    }
}

#[test]
fn a_count_that_comes_and_goes_is_less_than_a_count_of_motion() {
    let count_m = 50e-6;
    let settings = DampingSettings { velocity_share: 1.0, ..DampingSettings::NONE };
    let mut damping = Damping::build(&settings, TICK_S, count_m).unwrap();
    damping.track(Vector3::zeros(), 1.0 / TICK_S);
    for n in 0..10 {
        let up = n % 2 == 0;
        damping.track(Vector3::new(0.0, 0.0, if up { count_m } else { 0.0 }), 1.0 / TICK_S);
        let moved_counts = damping.velocity_m_per_s().z * TICK_S / count_m;
        let expected = if n == 0 {
            0.8..=1.001
        } else if up {
            0.799..=0.801
        } else {
            -0.801..=-0.799
        };
        assert!(expected.contains(&moved_counts), "{n}: {moved_counts} counts");
    }
}

#[test]
fn reset_forgets_place_and_velocity() {
    let mut damping = moving(DampingSettings::safe(1e-3, TICK_S), Vector3::new(0.0, 0.0, -0.5), 0.0);
    Shaper::reset(&mut damping);
    assert_eq!(damping.velocity_m_per_s(), Vector3::zeros());
    damping.track(Vector3::new(0.0, 0.0, 0.3), 1.0 / TICK_S);
    assert_eq!(damping.velocity_m_per_s(), Vector3::zeros(), "the next pose is the first");
}

#[test]
fn damping_grows_with_the_tangent_up_to_its_largest_value() {
    let into = moving(tangent_only(2e-3), Vector3::new(0.0, 0.0, -0.05), 0.0);
    for (tangent_n_per_m, n_s_per_m) in [(500.0, 1.0), (5e3, 10.0), (1e4, 20.0), (1e6, MOST_N_S_PER_M)] {
        let force_n = into.damp(&pushing(1e-3, 1.0), tangent_n_per_m);
        assert!((force_n.z - (1.0 + n_s_per_m * 0.05)).abs() < 1e-3, "{tangent_n_per_m} N/m: {force_n}");
    }
}

#[test]
fn the_constant_part_is_faded_in_over_the_first_tenth_of_a_newton() {
    let settings = DampingSettings { constant_n_s_per_m: 2.0, ..DampingSettings::NONE };
    let into = moving(settings, Vector3::new(0.0, 0.0, -0.05), 0.0);
    for (push_n, share) in [(0.01, 0.1), (0.05, 0.5), (0.1, 1.0), (1.0, 1.0)] {
        let force_n = into.damp(&pushing(1e-3, push_n), 0.0);
        assert!((force_n.z - (push_n + 2.0 * share * 0.05)).abs() < 1e-4, "{push_n} N: {force_n}");
    }
}

#[test]
fn going_out_takes_away_at_most_the_push() {
    let out = moving(tangent_only(2e-3), Vector3::new(0.3, 0.0, 0.05), 0.0);
    let force_n = Vector3::new(0.2, -0.1, 1.0);
    let output = Output { force_n, normal: Vector3::z(), depth_m: 1e-3, ..Output::NONE };
    assert!((out.damp(&output, 2e3) - Vector3::new(0.2, -0.1, 0.8)).norm() < 1e-3, "the part along the surface is not ours");
    let fast = moving(tangent_only(2e-3), Vector3::new(0.0, 0.0, 0.5), 0.0);
    assert_eq!(fast.damp(&output, 1e6), Vector3::new(0.2, -0.1, 0.0));
}

#[test]
fn what_does_not_push_is_not_damped() {
    let into = moving(DampingSettings::safe(1e-3, TICK_S), Vector3::new(0.0, 0.0, -0.5), 0.0);
    assert_eq!(into.damp(&Output::NONE, 1e4), Vector3::zeros());
    let pulls = Output { force_n: Vector3::new(0.1, 0.0, -0.5), normal: Vector3::z(), depth_m: 1e-3, ..Output::NONE };
    assert_eq!(into.damp(&pulls, 1e4), pulls.force_n);
}

#[test]
fn the_hertz_slope_ends_at_the_shallowest_depth() {
    for (depth_m, n_per_m) in [(3e-3, 500.0), (0.5e-3, 3e3), (0.3e-3, 5e3), (0.1e-3, 5e3), (0.0, 5e3)] {
        let slope = hertz_slope_n_per_m(&pushing(depth_m, 1.0));
        assert!((slope / n_per_m - 1.0).abs() < 1e-5, "{depth_m} m: {slope} N/m");
    }
    let tilted = Output { force_n: Vector3::new(3.0, 0.0, 4.0), normal: Vector3::z(), depth_m: 2e-3, ..Output::NONE };
    assert!((hertz_slope_n_per_m(&tilted) - 3e3).abs() < 0.1, "the part along the normal");
}

#[test]
fn the_velocity_follows_a_hand_that_turns_round_at_any_speed() {
    let count_m = 50e-6;
    for back_share in [0.1, 0.3, 0.5, 0.7, 0.7068, 0.8, 1.0] {
        let mut damping = moving(DampingSettings::safe(1e-3, TICK_S), Vector3::new(0.0, 0.0, 1.0), count_m);
        let end_m = TICK_S * 299.0;
        damping.track(Vector3::new(0.0, 0.0, end_m - back_share * TICK_S), 1.0 / TICK_S);
        let behind = damping.velocity_m_per_s().z + back_share;
        assert!(behind.abs() <= 1.25 * count_m / TICK_S, "{back_share} m/s back: {behind} m/s behind");
    }
}
