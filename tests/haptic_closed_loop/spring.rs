//! A plain spring: raw it shakes the hand, damped by its tangent it does not.

use palpate::haptic::cycle::{Renderer, Settings};
use palpate::haptic::damping::DampingSettings;
use palpate::haptic::passivity::PassivitySettings;
use palpate::path::probe::ProbePose;
use palpate::{Fault, Output, Vector3};

use crate::plant::{ARM, COUNT_M, FIRM_FINGER, FRICTION_N, LIGHT_FINGER, RELEASED, tap};

/// A spring of known stiffness below z = 0.
struct Spring {
    n_per_m: f32,
}

impl Renderer for Spring {
    fn render(&mut self, pose: ProbePose) -> Output {
        let depth_m = -pose.tip_m.z;
        if depth_m <= 0.0 {
            return Output { point_m: pose.tip_m, ..Output::NONE };
        }
        Output { force_n: Vector3::z() * (self.n_per_m * depth_m), depth_m, normal: Vector3::z(), ..Output::NONE }
    }

    fn reset(&mut self) {}

    fn tangent_n_per_m(&self, output: &Output) -> f32 {
        if output.depth_m > 0.0 { self.n_per_m } else { 0.0 }
    }
}

/// The model's force as it is, and the last resort as late as it may be set.
fn raw(delay: u8) -> Settings {
    Settings { damping: DampingSettings::NONE, passivity: PassivitySettings::HIGHEST, ..Settings::safe(delay) }
}

#[test]
fn a_raw_spring_shakes_a_released_hand_far_below_400() {
    for (delay, n_per_m) in [(0, 850.0), (1, 160.0), (2, 80.0)] {
        let run = tap(&mut Spring { n_per_m }, delay, FRICTION_N, raw(delay), |_| RELEASED);
        assert!(run.limit_cycle(), "delay {delay}, {n_per_m} N/m: {run:?}");
        assert!(run.created_j > 0.5e-3, "delay {delay}: {run:?}");
    }
    let run = tap(&mut Spring { n_per_m: 400.0 }, 1, 0.0, raw(1), |_| LIGHT_FINGER);
    assert!(run.created_j > 0.5e-3, "stable and yet not passive: {run:?}");
}

#[test]
fn damped_by_the_tangent_400_n_per_m_is_quiet_in_every_hand() {
    for delay in [0, 1, 2] {
        for friction_n in [FRICTION_N, 0.0] {
            for (name, hand) in [("released", RELEASED), ("light", LIGHT_FINGER), ("firm", FIRM_FINGER), ("arm", ARM)] {
                let run = tap(&mut Spring { n_per_m: 400.0 }, delay, friction_n, Settings::safe(delay), |_| hand);
                assert!(!run.limit_cycle(), "{name}, delay {delay}, friction {friction_n} N: {run:?}");
                assert!(run.created_j <= 0.01e-3, "{name}, delay {delay}, friction {friction_n} N: {run:?}");
            }
            let grips = |t: f64| if t > 2.25 || (t * 4.0).fract() < 0.5 { LIGHT_FINGER } else { FIRM_FINGER };
            let run = tap(&mut Spring { n_per_m: 400.0 }, delay, friction_n, Settings::safe(delay), grips);
            assert!(!run.limit_cycle(), "changing grip, delay {delay}, friction {friction_n} N: {run:?}");
            assert!(run.created_j <= 0.01e-3, "changing grip, delay {delay}, friction {friction_n} N: {run:?}");
        }
    }
}

#[test]
fn damping_leaves_the_static_force_alone() {
    for hand in [RELEASED, LIGHT_FINGER, FIRM_FINGER] {
        let last = tap(&mut Spring { n_per_m: 400.0 }, 1, FRICTION_N, Settings::safe(1), |_| hand).last;
        assert!(last.output.force_n.z > 0.1, "{last:?}");
        assert_eq!(last.applied_n, last.output.force_n);
    }
}

#[test]
fn the_observer_sees_the_energy_that_the_plant_gets() {
    // counting fakes up to the longest force times one count
    for (n_per_m, delay) in [(100.0, 1), (160.0, 1), (80.0, 2)] {
        let run = tap(&mut Spring { n_per_m }, delay, FRICTION_N, raw(delay), |_| RELEASED);
        assert!(run.created_j > 0.3e-3, "{run:?}");
        assert!((run.created_j - run.counted_j).abs() < 3.0 * COUNT_M, "{n_per_m} N/m: {run:?}");
    }
}

#[test]
fn the_last_resort_ends_what_the_raw_spring_does() {
    for delay in [1, 2] {
        let settings = Settings { damping: DampingSettings::NONE, ..Settings::safe(delay) };
        let free = tap(&mut Spring { n_per_m: 400.0 }, delay, 0.0, raw(delay), |_| RELEASED);
        let watched = tap(&mut Spring { n_per_m: 400.0 }, delay, 0.0, settings, |_| RELEASED);
        assert!(free.created_j > 2e-3 && free.last.fault.is_none(), "{free:?}");
        assert!(watched.created_j < 0.5 * free.created_j, "{} J instead of {} J", watched.created_j, free.created_j);
        // contact after contact, or sunk through a spring that has faded: then it is a fault, and the hand is let go
        assert!(matches!(watched.last.fault, None | Some(Fault::EnergyCreated | Fault::ForceImplausible)), "{watched:?}");
        assert!(watched.last.fault.is_none() || watched.last.applied_n == Vector3::zeros());
    }
}
